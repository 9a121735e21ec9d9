// Every key of the configuration, violated in every way that its schema knows: the error names the place,
// alone and among all others.
#include "tests/config/violations.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "tests/config/support.hpp"

namespace slipd::test {
namespace {

using nlohmann::json;

bool named(const std::vector<std::string>& problems, const std::string& pointer) {
  return std::any_of(problems.begin(), problems.end(), [&](const std::string& line) {
    const std::string start = "t.json: " + pointer;
    return line.starts_with(start) && line.size() > start.size() &&
           std::string(" /:").find(line[start.size()]) != std::string::npos;
  });
}

std::string swapped(std::string key) {
  std::swap(key[key.size() / 2 - 1], key[key.size() / 2]);
  return key[key.size() / 2 - 1] == key[key.size() / 2] ? key + "x" : key;
}

TEST(Violations, TheDocumentThatIsBrokenHereIsWholeAndValid) {
  EXPECT_THAT(problems_of(whole_document()), testing::IsEmpty());
  Survey s = survey(schema(), whole_document());
  s.seen.insert(".alerts.sigmas");  // stands instead of .alerts.cost only
  EXPECT_EQ(s.seen, s.all);
  EXPECT_GE(s.all.size(), 60U);
}

TEST(Violations, EverySingleOneIsNamed) {
  for (const auto& violation : survey(schema(), whole_document()).violations) {
    json document = whole_document();
    document[violation.at] = violation.bad;
    const std::string at = violation.at.empty() ? "/" : violation.at.to_string();
    EXPECT_TRUE(named(problems_of(document), at)) << at << " = " << violation.bad.dump().substr(0, 60);
  }
}

TEST(Violations, AllAreNamedAtOnce) {
  std::map<std::string, Violation> leaves;
  for (const auto& violation : survey(schema(), whole_document()).violations) {
    if (whole_document()[violation.at].is_primitive()) leaves.emplace(violation.at.to_string(), violation);
  }
  json document = whole_document();
  for (const auto& [at, violation] : leaves) document[violation.at] = violation.bad;
  const auto problems = problems_of(document);
  for (const auto& [at, violation] : leaves) EXPECT_TRUE(named(problems, at)) << at;
  EXPECT_GE(leaves.size(), 60U);
}

TEST(Violations, EveryMisspeltKeyIsNamedWithTheOneThatWasMeant) {
  for (const auto& key : survey(schema(), whole_document()).keys) {
    if (key.name.size() < 3) continue;  // too short to recognise a misspelling
    json document = whole_document();
    json& parent = document[key.parent];
    parent[swapped(key.name)] = parent[key.name];
    parent.erase(key.name);
    const std::string at = (key.parent / swapped(key.name)).to_string();
    EXPECT_THAT(problems_of(document),
                testing::Contains(testing::AllOf(testing::StartsWith("t.json: " + at + " = "),
                                                 testing::HasSubstr("did you mean \"" + key.name + "\"?"))));
  }
}

TEST(Violations, EveryMissingKeyIsNamedOrHasADefault) {
  for (const auto& key : survey(schema(), whole_document()).keys) {
    json document = whole_document();
    document[key.parent].erase(key.name);
    const auto problems = problems_of(document);
    const bool required = key.name == "sensors" || key.name == "name" || key.name == "driver" ||
                          key.name == "interface" || key.name == "at_mm" || key.name == "normal" ||
                          key.name == "x";
    // grid, pitch_mm and taxels need each other, and a grasp needs its sensor's name: reported, but
    // elsewhere.
    if (required) {
      EXPECT_TRUE(named(problems, (key.parent / key.name).to_string())) << key.parent / key.name;
    } else if (!key.parent.to_string().ends_with("/layout")) {
      EXPECT_THAT(problems, testing::IsEmpty());
    }
  }
}

void describes_itself(const json& schema, const std::string& at, bool needs_words) {
  EXPECT_TRUE(!needs_words || schema.contains("description")) << at;
  if (schema.contains("type") && (schema["type"] == "number" || schema["type"] == "integer")) {
    EXPECT_TRUE(schema.contains("minimum") || schema.contains("exclusiveMinimum")) << at;
    EXPECT_TRUE(schema.contains("maximum") || schema.contains("exclusiveMaximum")) << at;
    EXPECT_TRUE(schema.contains("unit") || schema["type"] == "integer") << at << " has no unit";
  }
  for (const char* keyword : {"properties", "$defs"}) {
    if (!schema.contains(keyword)) continue;
    for (const auto& [key, sub] : schema[keyword].items())
      describes_itself(sub, std::string(at).append(".").append(key), keyword[0] == 'p');
  }
  if (schema.contains("items")) describes_itself(schema["items"], at + "[]", false);
  if (!schema.contains("anyOf")) return;
  for (const auto& choice : schema["anyOf"]) describes_itself(choice, at, false);
}

TEST(Violations, EveryKeyHasAMeaningAndEveryNumberItsRangeAndUnit) {
  describes_itself(schema(), "", false);
}

}  // namespace
}  // namespace slipd::test
