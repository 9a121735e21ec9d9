#include "bridges/web/settings.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bridges/support/settings_file.hpp"
#include "bridges/web/live_session.hpp"
#include "embedded/slipd_web_schema.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::web {
namespace {

using ::testing::HasSubstr;

nlohmann::json parsed(const std::string& text) {
  return bridges::parse_settings(text, "web.json", slipd_web_schema, further_problems);
}

std::string problem_in(const std::string& text) {
  try {
    parsed(text);
    return "";
  } catch (const SettingsError& error) {
    return error.problems().at(0);
  }
}

TEST(WebSettings, TheExampleHasTheDefaults) {
  const auto example =
      bridges::load_settings(SLIPD_SOURCE_DIR "/bridges/web/web.json", slipd_web_schema, further_problems);
  EXPECT_EQ(example, parsed("{}"));
  const Settings settings = settings_from(example);
  EXPECT_EQ(settings.address, "127.0.0.1");
  EXPECT_EQ(settings.port, 8077);
}

TEST(WebSettings, BeyondThisMachineATokenIsNeeded) {
  for (const char* own : {"127.0.0.1", "127.8.8.8", "::1"})
    EXPECT_EQ(problem_in(std::string(R"({"listen":{"address":")") + own + "\"}}"), "");
  for (const char* other : {"0.0.0.0", "::", "192.168.1.1"}) {
    const std::string listen = std::string(R"("listen":{"address":")") + other + "\"}";
    EXPECT_THAT(problem_in("{" + listen + "}"), HasSubstr("token_file"));
    EXPECT_EQ(problem_in("{" + listen + R"(,"token_file":"/x"})"), "");
  }
  EXPECT_THAT(problem_in(R"({"listen":{"address":"localhost"}})"), HasSubstr("is no IP address"));
}

TEST(WebSettings, ATokenIsLongAndPlain) {
  const testing::TempFolder folder;
  EXPECT_EQ(read_token(folder.write("a", "0123456789abcdef\r\n")), "0123456789abcdef");
  EXPECT_THROW(read_token(folder.write("b", "short\n")), std::runtime_error);
  EXPECT_THROW(read_token(folder.write("c", "0123456789 abcdef")), std::runtime_error);
  EXPECT_THROW(read_token("/nowhere"), std::runtime_error);
}

TEST(Messages, AreFourWordsAndNothingElse) {
  EXPECT_EQ(said("ready").word, Word::ready);
  EXPECT_EQ(said("drawn").word, Word::drawn);
  EXPECT_EQ(said("look").word, Word::look);
  EXPECT_EQ(said("look left one").name, "left one");
  for (const char* other : {"", "look ", "looks", "LOOK", "ready ", " ready"})
    EXPECT_EQ(said(other).word, Word::unknown) << other;
  EXPECT_EQ(said("look " + std::string(64, 'x')).word, Word::unknown);
}

}  // namespace
}  // namespace slipd::web
