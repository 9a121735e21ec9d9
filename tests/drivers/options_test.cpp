// Drivers' schemas are within what the configuration understands, refuse what is out of range, and fill in
// what is absent.
#include "drivers/sim/options.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "embedded/replay_options.hpp"
#include "embedded/sim_options.hpp"
#include "schema/schema.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace slipd {
namespace {

using nlohmann::json;

std::vector<std::string> places(std::string_view schema, json options) {
  std::vector<std::string> found;
  for (const auto& problem : check(json::parse(schema), options)) found.push_back(problem.pointer);
  return found;
}

TEST(DriverOptions, OfSimFillInEverythingAndTheDriverTakesIt) {
  json options = json::object();
  EXPECT_TRUE(check(json::parse(sim_options), options).empty());
  EXPECT_EQ(options.at("object").at("radius_mm"), "flat");
  EXPECT_GT(options.at("cycle").size(), 10U);
  const auto given = sim::parse_options(test::setup_of(TaxelLayout::grid(4, 4, 0.003), options));
  const auto absent = sim::parse_options(test::setup_of(TaxelLayout::grid(4, 4, 0.003), json::object()));
  EXPECT_EQ(given.sensor.cycle.size(), absent.sensor.cycle.size());
  EXPECT_EQ(given.sensor.imperfections.noise, absent.sensor.imperfections.noise);
}

TEST(DriverOptions, OfSimAreRefusedWhereTheyAreOutOfRange) {
  using Places = std::vector<std::string>;
  EXPECT_EQ(places(sim_options, {{"drop", 1}}), Places{"/drop"});
  EXPECT_EQ(places(sim_options, {{"noise_kind", "white"}}), Places{"/noise_kind"});
  EXPECT_EQ(places(sim_options, {{"cycle", json::array()}}), Places{"/cycle"});
  EXPECT_EQ(places(sim_options, {{"cycle", {{{"ms", 10}, {"friction", 0}}}}}), Places{"/cycle/0/friction"});
  EXPECT_EQ(places(sim_options, {{"speed", 2}}), Places{"/speed"});
  EXPECT_EQ(places(sim_options, {{"tempo", 1}}), Places{"/tempo"});
}

TEST(DriverOptions, OfReplayNeedAFileAndTakeBiasAndScaleInEveryForm) {
  EXPECT_EQ(places(replay_options, json::object()).size(), 1U);
  EXPECT_TRUE(places(replay_options, {{"file", "a"}, {"scale", 2}, {"bias", {1, 2, 3, 4, 5, 6}}}).empty());
  EXPECT_TRUE(places(replay_options, {{"file", "a"}, {"scale", {1, 2, 3}}, {"bias", 0}}).empty());
  EXPECT_FALSE(places(replay_options, {{"file", "a"}, {"scale", {1, 2}}}).empty());
  EXPECT_FALSE(places(replay_options, {{"file", "a"}, {"speed", -1}}).empty());
  EXPECT_FALSE(places(replay_options, {{"file", 5}}).empty());
}

}  // namespace
}  // namespace slipd
