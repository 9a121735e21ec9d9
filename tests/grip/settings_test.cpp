// What slipd-grip refuses of its settings and of a gripper's profile before anything moves.
#include "grip/settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "grip/grippers/gripper_profile.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::grip {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

json settings_with(const std::string& profile, double firm_n, double most_n, double speed_mm_s) {
  return {{"fingers", {"left"}},
          {"socket", "/run/slipd/slipd.sock"},
          {"orders", "/run/slipd-grip/orders.sock"},
          {"firm_by", "firm_n"},
          {"target_margin", 0.4},
          {"settle_ms", 500},
          {"ahead_ms", 100},
          {"max_age_ms", 50},
          {"close_timeout_s", 5},
          {"dry_run", false},
          {"speed_mm_s", speed_mm_s},
          {"force",
           {{"close_n", 2},
            {"least_n", 1},
            {"firm_n", firm_n},
            {"most_n", most_n},
            {"resolution_n", 0},
            {"raise_n_per_s", 400},
            {"lower_per_s", 1}}},
          {"gripper",
           {{"type", "modbus"},
            {"profile", profile},
            {"at", "/dev/null"},
            {"delay_ms", 20},
            {"answer_ms", 200}}}};
}

std::vector<std::string> refused(const json& settings) {
  std::vector<std::string> where;
  for (const Problem& problem : problems_of(settings)) where.push_back(problem.pointer);
  return where;
}

TEST(GripSettings, AskForNoMoreThanTheGripperCan) {
  EXPECT_THAT(refused(settings_with("onrobot-rg2", 20, 40, 50)), IsEmpty());
  EXPECT_THAT(refused(settings_with("onrobot-rg2", 60, 80, 50)),
              ElementsAre("/force/firm_n", "/force/most_n"));
  EXPECT_THAT(refused(settings_with("robotiq-2f85", 30, 60, 5)), ElementsAre("/speed_mm_s"));
  EXPECT_THAT(refused(settings_with("robotiq-2f85", 8, 10, 50)), ElementsAre("/force/most_n"));
  EXPECT_THAT(refused(settings_with("no-such-gripper", 8, 10, 50)), ElementsAre("/gripper/profile"));
}

TEST(GripSettings, ReckonWithTheLeastForceOfTheGripper) {
  const LawSettings law = settings_of(settings_with("robotiq-2f85", 30, 60, 50)).law;
  EXPECT_EQ(law.least_n, 20);
  EXPECT_EQ(law.close_n, 20);
}

// The RG2's profile, changed at one place.
std::string trouble_of_profile(const std::string& pointer, const json& value) {
  const testing::TempFolder folder;
  json profile = json::parse(std::ifstream(SLIPD_SOURCE_DIR "/grip/grippers/profiles/onrobot-rg2.json"));
  profile[json::json_pointer(pointer)] = value;
  const auto file = folder.path() / "gripper.json";
  std::ofstream(file) << profile;
  try {
    load_profile(file.string());
  } catch (const GripperError& error) {
    return error.what();
  }
  return {};
}

TEST(GripperProfiles, AreRefusedWhereTheyCannotWork) {
  EXPECT_EQ(trouble_of_profile("/description", "as it is"), "");
  EXPECT_THAT(trouble_of_profile("/write/fields/2/index", 3), HasSubstr("behind the last register"));
  EXPECT_THAT(trouble_of_profile("/read/width/index", 2), HasSubstr("behind the last register"));
  EXPECT_THAT(trouble_of_profile("/write/fields/2/is", "speed"), HasSubstr("needs the gripper's \"speed\""));
  EXPECT_THAT(trouble_of_profile("/write/fields/2", {{"index", 2}, {"is", "constant"}}),
              HasSubstr("needs \"count\""));
  EXPECT_THAT(trouble_of_profile("/force/range_n", {40, 40}), HasSubstr("is no range"));
}

}  // namespace
}  // namespace slipd::grip
