// Estimates as clients receive them: unknown values are null, and gamma is a number in state ok only.
#include "daemon/rpc/methods/estimate_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/rpc/methods/status.hpp"
#include "daemon/rpc/protocol/text.hpp"

namespace slipd {
namespace {

const Now kNow{.monotonic_ns = 5'000'000'000, .realtime_ns = 1'790'000'005'000'000'000};

Estimate known() {
  Estimate estimate;
  estimate.state = State::ok;
  estimate.gamma = 0.62;
  estimate.sigma = 0.01;
  estimate.center_x_m = 1e-4;
  estimate.center_y_m = -4e-4;
  estimate.radius_m = 3.1e-3;
  estimate.torque_nm = -1.5e-3;
  estimate.torque_sigma_nm = 2e-5;
  estimate.turned_rad = 0.1;
  estimate.turned_sigma_rad = 0.01;
  estimate.time_to_slip_s = 0.05;
  estimate.time_ns = 4'999'000'000;
  estimate.published_ns = 4'999'035'200;
  estimate.truth = {0.615, 0.44};
  return estimate;
}

nlohmann::json read_estimate(const Estimate& estimate, const std::string& sensor, bool simulated,
                             const Now& now) {
  std::string text;
  EstimateText(estimate, sensor, simulated).append_to(text, now);
  return nlohmann::json::parse(text);
}

nlohmann::json read_grasp(const Estimate& together, const std::string& name,
                          const std::vector<std::string>& sensors) {
  std::string text;
  append_grasp(text, together, name, sensors);
  return nlohmann::json::parse(text);
}

TEST(EstimateText, IsKeptWhileItsEstimateIsTheNewestAndOnlyItsAgeGoesOn) {
  Estimate estimate = known();
  const EstimateText text(estimate, "left", true);
  EXPECT_FALSE(EstimateText().is_of(Estimate{}, false));
  EXPECT_TRUE(text.is_of(estimate, true));
  EXPECT_FALSE(text.is_of(estimate, false));
  estimate.published_ns += 1;
  EXPECT_FALSE(text.is_of(estimate, true));
  std::string first, later;
  text.append_to(first, kNow);
  text.append_to(later, {kNow.monotonic_ns + 1'250'000, kNow.realtime_ns + 1'250'000});
  auto before = nlohmann::json::parse(first), after = nlohmann::json::parse(later);
  EXPECT_EQ(after["age_ms"], before["age_ms"].get<double>() + 1.25);
  after["age_ms"] = before["age_ms"];
  EXPECT_EQ(after, before);
}

TEST(EstimateText, AgesHaveNanoseconds) {
  const auto said = [](std::int64_t time_ns) {
    std::string text;
    append_ms(text, time_ns);
    return text;
  };
  EXPECT_EQ(said(0), "0.0");
  EXPECT_EQ(said(1), "0.000001");
  EXPECT_EQ(said(1'000'000), "1.0");
  EXPECT_EQ(said(12'345'600'000), "12345.6");
  EXPECT_EQ(said(999'999), "0.999999");
}

TEST(TradeoffJson, SettingsThatAMethodHasNotAreNull) {
  WorkPrecision work_precision;
  work_precision.processor = "a processor";
  work_precision.rows.resize(2);
  work_precision.rows[0].method = "moments";
  work_precision.rows[0].mean_error = kUnknown;
  work_precision.rows[1].method = "registered";
  work_precision.rows[1].settings = {3, 16, 5, Precision::single_precision, 1000};
  const auto json = tradeoff_json("left", "moments", 50, work_precision);
  EXPECT_EQ(json["processor"], "a processor");
  EXPECT_TRUE(json["rows"][0]["rank"].is_null());
  EXPECT_TRUE(json["rows"][0]["mean_error"].is_null());
  EXPECT_EQ(json["rows"][0]["precision"], "double");
  EXPECT_EQ(json["rows"][1]["rank"], 3);
  EXPECT_EQ(json["rows"][1]["rings"], 16);
  EXPECT_EQ(json["rows"][1]["neighbours"], 5);
  EXPECT_EQ(json["rows"][1]["precision"], "single");
  EXPECT_EQ(json["rows"][1]["memory_bytes"], 1000);
}

TEST(EstimateText, UnitsAreThoseOfTheSocket) {
  const auto json = read_estimate(known(), "left", true, kNow);
  EXPECT_EQ(json["time_ns"], 1'790'000'004'999'000'000);
  EXPECT_DOUBLE_EQ(json["radius_mm"], 3.1);
  EXPECT_DOUBLE_EQ(json["torque_nmm"], -1.5);
  EXPECT_DOUBLE_EQ(json["torque_sigma_nmm"], 0.02);
  EXPECT_DOUBLE_EQ(json["turned_deg"], 18 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(json["turned_sigma_deg"], 1.8 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(json["center_mm"][1], -0.4);
  EXPECT_DOUBLE_EQ(json["time_to_slip_ms"], 50);
  EXPECT_DOUBLE_EQ(json["age_ms"], 1);
  EXPECT_DOUBLE_EQ(json["latency_us"], 35.2);
  EXPECT_EQ(json["class"], 4);
  EXPECT_DOUBLE_EQ(json["truth"]["gamma"], 0.615);
}

TEST(EstimateText, GammaIsANumberOnlyInStateOk) {
  for (int state = 0; state <= static_cast<int>(State::fault); ++state) {
    Estimate estimate = known();
    estimate.state = static_cast<State>(state);
    const auto json = read_estimate(estimate, "left", false, kNow);
    EXPECT_EQ(json["gamma"].is_number(), estimate.state == State::ok) << json["state"];
    EXPECT_EQ(json["class"].is_number(), estimate.state == State::ok) << json["state"];
  }
}

TEST(EstimateText, WhatIsUnknownIsNull) {
  Estimate estimate;
  estimate.state = State::ok;
  estimate.gamma = std::nan("");
  const auto json = read_estimate(estimate, "left", true, kNow);
  for (const char* key : {"gamma", "class", "sigma", "friction", "normal_n", "torque_nmm", "turned_deg",
                          "center_mm", "time_ns", "age_ms", "latency_us"}) {
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  EXPECT_TRUE(json["truth"]["gamma"].is_null());
}

TEST(EstimateText, AdviceComesWithItsErrorAndOnlyIfFrictionIsKnown) {
  Estimate estimate = known();
  estimate.grip_increase_n = 1.5;
  estimate.grip_increase_sigma_n = 0.2;
  for (const auto& json :
       {read_estimate(estimate, "left", false, kNow), read_grasp(estimate, "both", {"left"})}) {
    EXPECT_DOUBLE_EQ(json["grip_increase_n"], 1.5);
    EXPECT_DOUBLE_EQ(json["grip_increase_sigma_n"], 0.2);
    EXPECT_DOUBLE_EQ(json["time_to_slip_ms"], 50);
  }
  for (const auto& json :
       {read_estimate(known(), "left", false, kNow), read_grasp(known(), "both", {"left"})}) {
    EXPECT_TRUE(json["grip_increase_n"].is_null());
    EXPECT_TRUE(json["grip_increase_sigma_n"].is_null());
  }
}

TEST(EstimateText, ARealSensorHasNoTruth) {
  EXPECT_FALSE(read_estimate(known(), "left", false, kNow).contains("truth"));
}

TEST(EstimateText, ASampleFromAClockThatRunsAheadHasNoNegativeAge) {
  Estimate estimate = known();
  estimate.time_ns = kNow.monotonic_ns + 1'000'000'000;
  const auto json = read_estimate(estimate, "left", false, kNow);
  EXPECT_EQ(json["age_ms"], 0);
  EXPECT_EQ(json["latency_us"], 0);
}

TEST(EstimateText, NumbersReadBackAsTheSameAndNamesAsTheyWere) {
  for (const double value : {0.1, 1.0 / 3, 1e-300, 123456789.0, 5e-324, -2.5, 1e22, 0.0}) {
    Estimate estimate = known();
    estimate.gamma = value;
    const auto json = read_estimate(estimate, "left", false, kNow);
    EXPECT_EQ(json["gamma"].get<double>(), value);
    EXPECT_TRUE(json["gamma"].is_number_float()) << "an integer would be another type to some clients";
  }
  for (const std::string name : {"left", "a \"b\" \\ c", "\t", "gr\xC3\xBC\xC3\x9F"})
    EXPECT_EQ(read_grasp(known(), name, {name, "other"})["sensors"][0], name);
  EXPECT_EQ(read_estimate(known(), "\xFF", false, kNow)["sensor"], "\xEF\xBF\xBD")
      << "bytes that are no text";
}

}  // namespace
}  // namespace slipd
