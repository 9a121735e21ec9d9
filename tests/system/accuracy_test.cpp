// Compares estimates with the truth of simulated sensors, frame by frame: first without the daemon, then on
// the socket, where each frame must have the same estimate. Recorded frames of a real sensor have no truth;
// of them only states and trends are tested. Sensors play at speed 0, so nothing here depends on how fast
// the machine is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>

#include "config/settings.hpp"
#include "core/chain/chain.hpp"
#include "daemon/pipeline/modules.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

// The load rises from nothing to slip at constant normal force, again and again, each time with another
// friction.
json rising_loads() {
  json cycle = json::array();
  for (const double friction : {0.2, 0.4, 0.6, 0.8}) {
    cycle.push_back({{"ms", 50}, {"normal_n", 0}, {"shear_n", 0}, {"friction", friction}});
    cycle.push_back({{"ms", 50}, {"normal_n", {0.1, 1 + 2 * friction}}});
    cycle.push_back({{"ms", 400}, {"load", {0, 1}}});
  }
  return cycle;
}

json simulated(const json& options) {
  json all = {{"noise", 0.01}, {"noise_kind", "relative"}, {"speed", 0}};
  all.update(options);
  return {
      {"name", "finger"}, {"driver", "sim"}, {"rate_hz", 200}, {"stale_after_ms", 60'000}, {"options", all}};
}

// One sensor's driver and estimator, as the daemon runs them, without the daemon.
class FrameByFrame {
 public:
  explicit FrameByFrame(const json& config)
      : settings_(parse_settings(config.dump(), "test", modules_)),
        driver_(modules_.find("sim")->create({settings_.sensors.at(0).setup})),
        info_(driver_->open().sensors.at(0)),
        memory_(3 * info_.layout.size()),
        chain_(setup(), model()) {
    const std::span all(memory_);
    const std::size_t taxels = info_.layout.size();
    slot_.normal_pa = all.first(taxels);
    slot_.shear_x_pa = all.subspan(taxels, taxels);
    slot_.shear_y_pa = all.last(taxels);
  }

  // The estimate of the next frame, with the frame's truth.
  Estimate next() {
    EXPECT_EQ(driver_->read({&slot_, 1}, std::chrono::seconds(0)).status, ReadStatus::frame);
    slot_.zeroed = true;
    Estimate estimate = chain_.estimate(slot_.view());
    estimate.truth = slot_.truth;
    return estimate;
  }

 private:
  ChainSetup setup() const {
    return {.layout = info_.layout,
            .sensor_class = info_.sensor_class,
            .scene = settings_.scene_of(settings_.sensors.at(0)),
            .estimator = settings_.estimator,
            .alerts = settings_.alerts,
            .friction = settings_.sensors.at(0).friction};
  }
  std::shared_ptr<const Model> model() const {
    return needs_model(setup()) ? std::make_shared<const Model>(train(model_setup_of(setup()))) : nullptr;
  }

  DriverModules modules_{real_drivers()};
  Settings settings_;
  std::unique_ptr<DeviceDriver> driver_;
  SensorInfo info_;
  std::vector<float> memory_;
  FrameSlot slot_;
  EstimatorChain chain_;
};

struct MarginErrors {
  std::string worst_frame;                   // the estimate with the largest error
  int ok = 0, others = 0, far_too_safe = 0;  // the last: by more than 0.15
  double error = 0, worst = 0;
};

// The errors over this many frames in contact.
MarginErrors margin_errors(const json& config, int frames) {
  FrameByFrame played(config);
  MarginErrors errors;
  while (errors.ok + errors.others < frames) {
    const Estimate estimate = played.next();
    EXPECT_EQ(estimate.gamma.has_value(), estimate.state == State::ok);
    if (std::isnan(estimate.truth.gamma)) continue;
    if (!estimate.gamma) {
      ++errors.others;
      continue;
    }
    const double off = *estimate.gamma - estimate.truth.gamma;
    ++errors.ok;
    errors.error += std::fabs(off);
    if (std::fabs(off) > errors.worst) {
      errors.worst = std::fabs(off);
      errors.worst_frame = "frame " + std::to_string(estimate.sequence) + ": margin " +
                           std::to_string(*estimate.gamma) + ", true " + std::to_string(estimate.truth.gamma);
    }
    if (off > 0.15) ++errors.far_too_safe;
  }
  errors.error /= std::max(1, errors.ok);
  return errors;
}

class RisingLoads : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(RisingLoads, AreWithinTheErrorOfTheMethod) {
  const auto& [method, most_error] = GetParam();
  const TempFolder folder;
  const json estimator = {{"method", method}, {"tracking", false}, {"offset_mm", 0}, {"noise", 0.01}};
  const MarginErrors errors = margin_errors(
      config_with(folder, json::array({simulated({{"cycle", rising_loads()}})}), {{"estimator", estimator}}),
      1000);
  EXPECT_GT(errors.ok, 800);
  EXPECT_LE(errors.error, most_error);
  RecordProperty("mean_error", std::to_string(errors.error));
}

INSTANTIATE_TEST_SUITE_P(Methods, RisingLoads,
                         ::testing::Values(std::pair("svd-knn", 0.05), std::pair("moments", 0.02),
                                           std::pair("fit", 0.005)),
                         [](const auto& each) {
                           std::string name = each.param.first;
                           std::erase(name, '-');
                           return name;
                         });

TEST(AGraspsHistory, WithRegripUnloadingAndChangesOfFrictionGetsNoMarginThatIsFarOff) {
  for (const char* method : {"fit", "moments", "svd-knn"}) {
    SCOPED_TRACE(method);
    const TempFolder folder;
    const json estimator = {{"method", method}, {"offset_mm", 0}, {"noise", 0.01}};
    const MarginErrors errors = margin_errors(
        config_with(folder, json::array({simulated(json::object())}), {{"estimator", estimator}}), 1200);
    EXPECT_GT(errors.ok, 600);
    EXPECT_LE(errors.worst, 0.25) << errors.worst_frame;
    // The fall of friction in the cycle is told within three frames.
    EXPECT_LE(errors.far_too_safe, 3);
  }
}

// A client gets as many estimates as it can read. Each must equal the estimate of the same frame without the
// daemon.
TEST(OnTheSocket, EachEstimateIsThatOfItsFrameAndNoFrameIsSkipped) {
  for (const char* method : {"moments", "svd-knn"}) {
    SCOPED_TRACE(method);
    const TempFolder folder;
    json finger = simulated(json::object());
    finger["layout"] = {{"grid", {24, 24}}, {"pitch_mm", 0.6}};
    const json config =
        config_with(folder, json::array({finger}), {{"estimator", {{"method", method}, {"offset_mm", 0}}}});
    Daemon daemon(config, real_drivers(), {{"XDG_CACHE_HOME", folder.path().string()}});
    auto client = daemon.client();
    client.result("subscribe", {{"events", {"estimate"}}});
    std::map<std::uint64_t, json> online;
    while (online.size() < 300) {
      json estimate = client.notification().at("params");
      EXPECT_EQ(estimate["gamma"].is_number(), estimate["state"] == "ok") << estimate;
      if (estimate["normal_n"].is_number()) online.insert_or_assign(estimate["seq"], estimate);
    }
    const json sensor = client.result("status")["sensors"][0];
    EXPECT_EQ(sensor["skipped"], 0) << sensor;
    EXPECT_EQ(sensor["received"], sensor["estimated"]) << sensor;
    EXPECT_EQ(daemon.stop(), 0);

    FrameByFrame played(config);
    for (std::uint64_t sequence = 0; sequence <= online.rbegin()->first; ++sequence) {
      const Estimate estimate = played.next();
      ASSERT_EQ(estimate.sequence, sequence);
      const auto found = online.find(sequence);
      if (found == online.end()) continue;
      const json& received = found->second;
      ASSERT_EQ(received["state"], to_string(estimate.state)) << received;
      EXPECT_EQ(received["alert"], to_string(estimate.alert)) << received;
      EXPECT_EQ(received["method"], to_string(estimate.method)) << received;
      if (estimate.gamma) {
        EXPECT_NEAR(received["gamma"].get<double>(), *estimate.gamma, 1e-6) << received;
        EXPECT_NEAR(received["sigma"].get<double>(), *estimate.sigma, 1e-6) << received;
      }
    }
  }
}

// Three trials with two real fingertips. Counts are not newtons and most trials have no bias, so margins
// cannot be tested. The test checks that every row arrives, that no number comes outside state ok, and how
// Q/P develops.
std::filesystem::path trials() {
  const char* shared = std::getenv("SLIPD_SHARED");
  return std::filesystem::path(shared != nullptr ? shared : SLIPD_SOURCE_DIR "/../shared") / "data/uskin";
}

int rows_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return static_cast<int>(std::count(std::istreambuf_iterator<char>(in), {}, '\n')) - 1;
}

// The mean of each channel over the last 20 rows of the third trial, where the object has fallen: the only
// rows without load.
json zero_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<double> row;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::strtod(cell.c_str(), nullptr));
    rows.push_back(std::move(row));
  }
  std::vector<double> zero(48, 0);
  for (std::size_t r = rows.size() - 20; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < zero.size(); ++c) zero[c] += rows[r][c] / 20;
  }
  return zero;
}

TEST(RecordedGrasps, PlayToTheEndWithoutAMarginOutsideStateOk) {
  if (!std::filesystem::exists(trials()))
    GTEST_SKIP() << "needs " << trials() << ", which is not part of the project";
  const auto third = trials() / "2022-02-22-15-15-00";
  for (const char* name : {"2022-02-21-09-58-49", "2022-02-21-14-10-49", "2022-02-22-15-15-00"}) {
    SCOPED_TRACE(name);
    const TempFolder folder;
    json sensors = json::array();
    for (const char* finger : {"xela_sensor1", "xela_sensor2"}) {
      const auto file = trials() / name / (std::string(finger) + ".csv");
      sensors.push_back({{"name", finger},
                         {"driver", "replay"},
                         {"rate_hz", 60},
                         {"stale_after_ms", 5000},
                         {"layout", {{"grid", {4, 4}}, {"pitch_mm", 4.7}}},
                         {"options",
                          {{"file", file.string()},
                           {"speed", 0},
                           {"bias", zero_of(third / (std::string(finger) + ".csv"))},
                           {"scale", {1, 1, 1}}}}});
    }
    Daemon daemon(config_with(folder, sensors), real_drivers());
    const int rows = rows_of(trials() / name / "xela_sensor1.csv");
    const json status = daemon.wait_for("status", [&](const json& s) {
      return std::all_of(s["sensors"].begin(), s["sensors"].end(),
                         [&](const json& each) { return each["received"] >= rows; });
    });
    for (const json& sensor : status["sensors"]) {
      EXPECT_EQ(sensor["received"], rows);
      EXPECT_EQ(sensor["estimated"], rows) << "a replay at speed 0 loses nothing";
    }
  }
}

}  // namespace
}  // namespace slipd::testing
