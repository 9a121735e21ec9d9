#include "bridges/support/settings_file.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "tests/support/temp_folder.hpp"

namespace slipd::bridges {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TempFolder;

constexpr std::string_view kSchema = R"({"type": "object", "additionalProperties": false, "properties": {
  "rate_hz": {"type": "number", "minimum": 0.1, "maximum": 100, "default": 10, "unit": "Hz"},
  "host": {"type": "string", "minLength": 1}}})";

std::vector<std::string> problems_of(const std::string& text, const FurtherCheck& further = {}) {
  try {
    parse_settings(text, "x.json", kSchema, further);
  } catch (const SettingsError& error) {
    return error.problems();
  }
  return {};
}

TEST(SettingsFile, FillsInDefaults) {
  const auto settings = parse_settings("{ // nothing is said\n}", "x.json", kSchema);
  EXPECT_EQ(settings.at("rate_hz"), 10);
}

TEST(SettingsFile, NamesFilePlaceAndRangeOfEachProblem) {
  EXPECT_THAT(problems_of(R"({"rate_hz": 0, "host": ""})"),
              ::testing::UnorderedElementsAre(AllOf(HasSubstr("x.json: /rate_hz = 0"), HasSubstr("100 Hz")),
                                              HasSubstr("x.json: /host")));
}

TEST(SettingsFile, NamesTheLineOfAnErrorInTheText) {
  EXPECT_THAT(problems_of("{\n\"rate_hz\" 1}"), ElementsAre(HasSubstr("x.json:2:")));
}

TEST(SettingsFile, AsksFurtherRulesOnlyAboutSettingsThatFitTheSchema) {
  int asked = 0;
  const FurtherCheck refuse = [&](const nlohmann::json& settings) {
    ++asked;
    return std::vector{problem_of("/host", settings.value("host", ""), "is not here")};
  };
  EXPECT_THAT(problems_of(R"({"rate_hz": 0})", refuse), ElementsAre(HasSubstr("/rate_hz")));
  EXPECT_EQ(asked, 0);
  EXPECT_THAT(problems_of(R"({"host": "a"})", refuse), ElementsAre(HasSubstr("is not here")));
}

TEST(SettingsFile, RefusesWhatIsNoRegularFile) {
  const TempFolder folder;
  const auto pipe = folder.file("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(load_settings(pipe, kSchema), SettingsError);
  EXPECT_THROW(load_settings(folder.path(), kSchema), SettingsError);
  EXPECT_THROW(load_settings(folder.file("absent"), kSchema), SettingsError);
  EXPECT_EQ(load_settings(folder.write("there", R"({"rate_hz": 5})"), kSchema).at("rate_hz"), 5);
}

}  // namespace
}  // namespace slipd::bridges
