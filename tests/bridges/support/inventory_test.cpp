#include "bridges/support/inventory.hpp"

#include <gmock/gmock.h>

namespace slipd::bridges {
namespace {

constexpr const char* kVersion = R"({"name":"slipd","version":"0.1.0","protocol":1})";

TEST(Inventory, HasTheSensorsAndGraspsInTheirOrder) {
  const Inventory all = inventory_of(
      kVersion,
      R"({"sensors":[{"name":"right","driver":"sim","class":"array3","taxels":16,"rate_hz":100.0,"simulated":true},
          {"name":"left","driver":"hid","class":"wrench","taxels":1,"rate_hz":50,"simulated":false}]})",
      R"({"sensors":[],"grasps":[{"grasp":"gripper","sensors":["left","right"]}]})");
  const SensorFacts right{"right", "sim", "array3", 16, 100, true};
  const SensorFacts left{"left", "hid", "wrench", 1, 50, false};
  EXPECT_EQ(all, (Inventory{"0.1.0", {right, left}, {{"gripper", {"left", "right"}}}}));
  EXPECT_TRUE(all.has_sensor("left"));
  EXPECT_FALSE(all.has_sensor("gripper"));
  EXPECT_TRUE(all.has("left"));
  EXPECT_TRUE(all.has("gripper"));
  EXPECT_FALSE(all.has("lefft"));
}

TEST(Inventory, TakesAKeyOfAnotherTypeForAbsent) {
  const Inventory all = inventory_of(R"({"version":1})", R"({"sensors":[{"name":"a","taxels":"many"},3]})",
                                     R"({"grasps":{"grasp":"b"}})");
  SensorFacts only_named;
  only_named.name = "a";
  EXPECT_EQ(all, (Inventory{"", {only_named}, {}}));
}

TEST(Inventory, RefusesAnAnswerThatIsNoObject) {
  EXPECT_THROW(inventory_of(kVersion, "[]", "{}"), std::runtime_error);
  EXPECT_THROW(inventory_of(kVersion, "{}", "{"), std::runtime_error);
}

}  // namespace
}  // namespace slipd::bridges
