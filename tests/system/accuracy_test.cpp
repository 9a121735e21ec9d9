// The whole way, from the simulated sensor to the socket, held against the truth that travels beside the
// frames; and real frames of a real sensor, of which only trends are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <set>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

// The load rises from nothing to slip at constant force, again and again, with another friction each time.
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
  json all = {{"noise", 0.01}, {"noise_kind", "relative"}};
  all.update(options);
  return {
      {"name", "finger"}, {"driver", "sim"}, {"rate_hz", 200}, {"stale_after_ms", 2000}, {"options", all}};
}

struct Account {
  std::string worst_of_all;  // the estimate that was furthest off
  int ok = 0, others = 0;
  double error = 0, worst = 0, too_safe = -1;
};

// Listens until `estimates` frames of a contact with a known truth have come.
Account listen(const Daemon& daemon, int estimates) {
  auto client = daemon.client();
  client.result("subscribe", {{"events", {"estimate"}}});
  Account account;
  while (account.ok + account.others < estimates) {
    const json told = client.notification().at("params");
    EXPECT_EQ(told["gamma"].is_number(), told["state"] == "ok") << told;
    if (!told["truth"].is_object() || !told["truth"]["gamma"].is_number()) continue;
    if (told["state"] != "ok") {
      ++account.others;
      continue;
    }
    const double off = told["gamma"].get<double>() - told["truth"]["gamma"].get<double>();
    ++account.ok;
    account.error += std::fabs(off);
    if (std::fabs(off) > account.worst) {
      account.worst = std::fabs(off);
      account.worst_of_all = told.dump();
    }
    account.too_safe = std::max(account.too_safe, off);
  }
  account.error /= std::max(1, account.ok);
  return account;
}

class RisingLoads : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(RisingLoads, AreReadFromTheSocketAsNearToTheTruthAsTheMethodCan) {
  const auto& [method, most_error] = GetParam();
  const TempFolder folder;
  const json estimator = {{"method", method}, {"tracking", false}, {"offset_mm", 0}, {"noise", 0.01}};
  Daemon daemon(
      config_with(folder, json::array({simulated({{"cycle", rising_loads()}})}), {{"estimator", estimator}}),
      real_drivers(), {{"XDG_CACHE_HOME", folder.path().string()}});
  daemon.wait_for("gamma", [](const json& g) { return g["sensors"][0]["state"] == "ok"; });
  const Account account = listen(daemon, 1000);
  EXPECT_GT(account.ok, 800);
  EXPECT_LE(account.error, most_error);
  RecordProperty("mean_error", std::to_string(account.error));
}

INSTANTIATE_TEST_SUITE_P(Methods, RisingLoads,
                         ::testing::Values(std::pair("svd-knn", 0.05), std::pair("moments", 0.02),
                                           std::pair("fit", 0.005)),
                         [](const auto& each) {
                           std::string name = each.param.first;
                           std::erase(name, '-');
                           return name;
                         });

TEST(AGrippersLife, WithRegripUnloadingAndChangesOfFrictionNeverGetsAMarginThatIsFarOff) {
  for (const char* method : {"fit", "moments", "svd-knn"}) {
    SCOPED_TRACE(method);
    const TempFolder folder;
    const json estimator = {{"method", method}, {"offset_mm", 0}, {"noise", 0.01}};
    Daemon daemon(config_with(folder, json::array({simulated(json::object())}), {{"estimator", estimator}}),
                  real_drivers(), {{"XDG_CACHE_HOME", folder.path().string()}});
    daemon.wait_for("gamma", [](const json& g) { return g["sensors"][0]["state"] == "ok"; });
    const Account account = listen(daemon, 1200);
    EXPECT_GT(account.ok, 600);
    EXPECT_LE(account.worst, 0.25) << account.worst_of_all;
    EXPECT_LE(account.too_safe, 0.15);
  }
}

// Three trials of two real fingertips. Counts are no newtons and most trials have no zero, so margins cannot
// be tested: that every row arrives, that no number comes where nothing is known, and the course of Q/P can.
std::filesystem::path trials() {
  const char* shared = std::getenv("SLIPD_SHARED");
  return std::filesystem::path(shared != nullptr ? shared : SLIPD_SOURCE_DIR "/../shared") / "data/uskin";
}

int rows_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return static_cast<int>(std::count(std::istreambuf_iterator<char>(in), {}, '\n')) - 1;
}

// The mean of each channel over the last 20 rows of the third trial, where the object has fallen: the only
// true zero.
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

TEST(RecordedGrasps, PlayThroughWholeWithHonestStates) {
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
