// The schema walker by itself: what it accepts, fills in, and says.
#include "schema/schema.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace slipd {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

// The problems of a value as lines.
std::vector<std::string> lines(const char* schema, json value) {
  std::vector<std::string> out;
  for (const auto& problem : check(json::parse(schema), value)) out.push_back(problem.in("f"));
  return out;
}

json filled(const char* schema, json value) {
  EXPECT_THAT(check(json::parse(schema), value), IsEmpty());
  return value;
}

TEST(Schema, NamesRangeAndUnitOfANumber) {
  const char* schema = R"({"type": "number", "minimum": 1, "maximum": 2.5, "unit": "mm"})";
  EXPECT_THAT(lines(schema, 0), ElementsAre("f: / = 0: is too small; expected a number from 1 to 2.5 mm"));
  EXPECT_THAT(lines(schema, 3), ElementsAre("f: / = 3: is too large; expected a number from 1 to 2.5 mm"));
  EXPECT_THAT(lines(schema, "x"),
              ElementsAre("f: / = \"x\": is a string; expected a number from 1 to 2.5 mm"));
  EXPECT_THAT(lines(schema, 1), IsEmpty());
  EXPECT_THAT(lines(schema, 2.5), IsEmpty());
}

TEST(Schema, PutsOpenRangesIntoWords) {
  EXPECT_THAT(lines(R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1})", 0),
              ElementsAre("f: / = 0: is too small; expected a number above 0 up to 1"));
  EXPECT_THAT(lines(R"({"type": "number", "minimum": 0, "exclusiveMaximum": 1})", 1),
              ElementsAre("f: / = 1: is too large; expected a number of at least 0 and below 1"));
  EXPECT_THAT(lines(R"({"type": "number", "unit": "s"})", true),
              ElementsAre("f: / = true: is a boolean; expected a number in s"));
}

TEST(Schema, LetsNoNumberThroughThatIsNotFinite) {
  for (const double d : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(lines(R"({"type": "number"})", d), ElementsAre(testing::HasSubstr("is no finite number")));
  }
}

TEST(Schema, TakesAWholeNumberForAnIntegerAndMakesItOne) {
  EXPECT_TRUE(filled(R"({"type": "integer"})", 5.0).is_number_integer());
  EXPECT_THAT(lines(R"({"type": "integer"})", 5.5),
              ElementsAre("f: / = 5.5: is a fraction; expected an integer"));
  EXPECT_THAT(lines(R"({"type": "integer"})", 1e300), testing::SizeIs(1));
}

TEST(Schema, FillsInDefaultsAtEveryLevel) {
  const char* schema = R"({"type": "object", "properties": {
    "a": {"type": "object", "default": {}, "properties": {"b": {"default": [1]}}},
    "list": {"type": "array", "items": {"$ref": "#/$defs/item"}}, "absent": {"type": "string"} },
    "$defs": {"item": {"type": "object", "properties": {"c": {"default": 7}}}}})";
  EXPECT_EQ(filled(schema, json::object()), json::parse(R"({"a": {"b": [1]}})"));
  EXPECT_EQ(filled(schema, json::parse(R"({"a": {"b": 2}, "list": [{}, {"c": 1}]})")),
            json::parse(R"({"a": {"b": 2}, "list": [{"c": 7}, {"c": 1}]})"));
}

TEST(Schema, ReportsUnknownKeysWithTheLikelyOne) {
  const char* schema =
      R"({"type": "object", "additionalProperties": false, "properties": {"rate": {}, "name": {}}})";
  EXPECT_THAT(lines(schema, {{"rtae", 1}}),
              ElementsAre("f: /rtae = 1: is an unknown key; did you mean \"rate\"?"));
  EXPECT_THAT(lines(schema, {{"Rate", 1}}),
              ElementsAre("f: /Rate = 1: is an unknown key; did you mean \"rate\"?"));
  EXPECT_THAT(lines(schema, {{"zzzzz", 1}}),
              ElementsAre("f: /zzzzz = 1: is an unknown key; known here: name, rate"));
  EXPECT_THAT(lines(R"({"additionalProperties": false})", {{"a", 1}}),
              ElementsAre("f: /a = 1: is an unknown key; none is known here"));
}

TEST(Schema, ReportsMissingKeys) {
  EXPECT_THAT(lines(R"({"required": ["a"], "properties": {"a": {"type": "boolean"}}})", json::object()),
              ElementsAre("f: /a: is missing; expected true or false"));
}

TEST(Schema, FindsEveryProblemInLists) {
  const char* schema =
      R"({"type": "array", "minItems": 2, "maxItems": 3, "items": {"type": "integer"}, "uniqueItems": true})";
  EXPECT_THAT(lines(schema, json::parse(R"([1.5, "a", 1])")),
              ElementsAre(testing::StartsWith("f: /0 = 1.5"), testing::StartsWith("f: /1 = \"a\"")));
  EXPECT_THAT(lines(schema, {1}),
              ElementsAre("f: / = [1]: has too few items; expected a list of 2 to 3 items, each an integer"));
  EXPECT_THAT(lines(schema, {1, 2, 3, 4}), ElementsAre(testing::HasSubstr("has too many items")));
  EXPECT_THAT(lines(schema, {1, 2, 1}), ElementsAre("f: /2 = 1: is in the list twice; once is enough"));
}

TEST(Schema, CountsCharactersOfStringsAndSaysTheirForm) {
  EXPECT_THAT(lines(R"({"type": "string", "maxLength": 2})", "éé"), IsEmpty());
  EXPECT_THAT(lines(R"({"type": "string", "minLength": 1})", ""),
              ElementsAre(testing::HasSubstr("is too short")));
  const char* schema = R"({"type": "string", "pattern": "^0x[0-9a-f]+$", "form": "a hexadecimal number"})";
  EXPECT_THAT(lines(schema, "0x1f"), IsEmpty());
  EXPECT_THAT(lines(schema, "1f"),
              ElementsAre("f: / = \"1f\": has another form; expected a hexadecimal number"));
  EXPECT_THAT(lines(schema, "0x1f\n0x2e"), testing::SizeIs(1));
  EXPECT_THAT(lines(schema, std::string(1000000, 'f')), ElementsAre(testing::HasSubstr("is too long")));
}

TEST(Schema, OffersAllChoicesOfAnyOfWithTheCauseOfTheNearest) {
  const char* schema = R"({"anyOf": [{"type": "number", "minimum": 1, "unit": "mm"}, {"enum": ["flat"]}]})";
  EXPECT_THAT(lines(schema, "flat"), IsEmpty());
  EXPECT_THAT(
      lines(schema, 0),
      ElementsAre(testing::AllOf(testing::HasSubstr("expected a number of at least 1 mm or \"flat\""))));
  EXPECT_THAT(lines(schema, "flatt"),
              ElementsAre(testing::HasSubstr("expected a number of at least 1 mm or \"flat\"")));
  const char* range =
      R"({"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number", "maximum": 5}}]})";
  EXPECT_THAT(lines(range, {1, 9}), ElementsAre("f: /1 = 9: is too large; expected a number up to 5"));
}

TEST(Schema, WantsExactlyOneForOneOf) {
  const char* schema = R"({"oneOf": [{"required": ["a"]}, {"required": ["b"]}]})";
  EXPECT_THAT(lines(schema, {{"a", 1}}), IsEmpty());
  EXPECT_THAT(lines(schema, {{"a", 1}, {"b", 1}}), ElementsAre(testing::HasSubstr("fits more than one")));
  EXPECT_THAT(lines(schema, {{"c", 1}}), testing::SizeIs(1));
}

TEST(Schema, LetsDefsReferToThemselvesButNotForEver) {
  const char* tree = R"({"type": "object", "additionalProperties": {"$ref": "#"}})";
  EXPECT_THAT(lines(tree, json::parse(R"({"a": {"b": {}, "c": 1}})")),
              ElementsAre(testing::StartsWith("f: /a/c = 1")));
  EXPECT_THAT(lines(R"({"$ref": "#"})", 1), ElementsAre("f: / = 1: is nested too deeply"));
  json deep = json::object();
  for (int i = 0; i < 1000; ++i) deep = {{"a", std::move(deep)}};
  EXPECT_THAT(lines(tree, deep), ElementsAre(testing::HasSubstr("is nested too deeply")));
}

TEST(Schema, RefusesSchemasWithWordsOutsideOfTheSubset) {
  for (const char* schema : {R"({"typ": "object"})", R"({"type": "int"})", R"({"minimum": "1"})", R"([])",
                             R"({"properties": {"a": {"multipleOf": 2}}})", R"({"$ref": "#/$defs/none"})",
                             R"({"type": "string", "pattern": "["})", R"({"maxItems": -1})"}) {
    EXPECT_THROW(lines(schema, "x"), SchemaError) << schema;
  }
}

TEST(Schema, StopsCountingProblemsSomewhere) {
  json many = json::array();
  for (int i = 0; i < 100000; ++i) many.push_back("x");
  EXPECT_EQ(lines(R"({"items": {"type": "number"}})", many).size(), kMostProblems);
}

TEST(Schema, KeepsEachProblemOnOneLineOfBoundedLength) {
  const auto found =
      lines(R"({"additionalProperties": false})", {{"a\nb/c~d", std::string(1000, 'x')}, {"\x1b[31m", "\n"}});
  ASSERT_THAT(found, testing::SizeIs(2));
  for (const auto& line : found) {
    EXPECT_THAT(line, testing::Not(testing::ContainsRegex("[\n\x1b]")));
    EXPECT_LT(line.size(), 200U);
  }
  EXPECT_THAT(found, testing::Contains(testing::HasSubstr("/a\\nb~1c~0d = ")));
}

}  // namespace
}  // namespace slipd
