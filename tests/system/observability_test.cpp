// What an administrator sees of a running slipd: latencies, the estimator's expected error, metrics in a
// file, and a log without repetitions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

json left(const json& options = json::object()) {
  return trial_sensor("left", options, {{"rate_hz", 200}});
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(Observability, StatusTellsLatenciesAndWhatTheEstimatorIsWorthOnThisScene) {
  const TempFolder folder;
  const Daemon daemon(config_with(folder, json::array({left()})), trial_drivers());
  auto subscriber = daemon.client();
  subscriber.result("subscribe");
  subscriber.notification();
  const json status = daemon.wait_for("status", [](const json& s) {
    return s["sensors"][0]["received"] > 20 && s["sensors"][0]["single_frame_error"].is_object() &&
           s["outputs"]["socket"]["latency_us"]["max"].is_number();
  });
  const json& sensor = status["sensors"][0];
  const json& error = sensor["single_frame_error"];
  EXPECT_GT(error["mean"], 0);
  EXPECT_LT(error["mean"], 0.3);
  EXPECT_TRUE(error["p95"].is_null()) << "the table has means";
  EXPECT_GT(error["answered"], 0.5);
  for (const json* latency :
       {&sensor["latency_us"], &sensor["latency_last_minute_us"], &status["outputs"]["socket"]["latency_us"],
        &status["outputs"]["socket"]["latency_last_minute_us"]}) {
    EXPECT_GT((*latency)["p50"], 0);
    EXPECT_GE((*latency)["p99"], (*latency)["p50"]);
    EXPECT_GE((*latency)["p99.9"], (*latency)["p99"]);
    EXPECT_GE((*latency)["max"], (*latency)["p99.9"]);
  }
  const auto metrics = daemon.client().result("metrics").get<std::string>();
  for (const char* family : {"slipd_latency_seconds", "slipd_latency_last_minute_seconds"}) {
    for (const char* quantile : {"0.5", "0.99", "0.999", "1"})
      EXPECT_THAT(metrics,
                  HasSubstr(std::string(family) + "{sensor=\"left\",quantile=\"" + quantile + "\"} "));
  }
  EXPECT_THAT(metrics, HasSubstr("slipd_delivery_seconds{quantile=\"0.999\"} "));
}

// Prometheus' text format, as node_exporter reads it: a TYPE line precedes the samples of each family, names
// of counters end in _total, and only the format's types occur.
TEST(Observability, MetricsAreInAFileAsLongAsSlipdRuns) {
  const TempFolder folder;
  const auto file = folder.file("slipd.prom");
  Daemon daemon(
      config_with(folder, json::array({left()}), {{"metrics", {{"file", file.string()}, {"period_s", 1}}}}),
      trial_drivers());
  daemon.wait_for("version",
                  [&](const json&) { return text_of(file).find("slipd_gamma{") != std::string::npos; });
  struct stat there {};
  ASSERT_EQ(stat(file.c_str(), &there), 0);
  EXPECT_EQ(there.st_mode & 0777, 0644U);
  std::istringstream lines(text_of(file));
  const std::regex type("# TYPE ([a-z_]+) (counter|gauge|summary)");
  const std::regex sample("([a-z_]+)(\\{[^}]*\\})? [-+0-9.e]+");
  std::set<std::string> families;
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_match(line, found, type)) {
      EXPECT_TRUE(families.insert(found[1]).second) << "twice: " << line;
      EXPECT_EQ(found[2] == "counter", found[1].str().ends_with("_total")) << line;
    } else if (!line.starts_with("# HELP ")) {
      ASSERT_TRUE(std::regex_match(line, found, sample)) << line;
      std::string name = found[1];
      if (name.ends_with("_count")) name.resize(name.size() - 6);
      EXPECT_TRUE(families.count(name) > 0) << line;
    }
  }
  EXPECT_GT(families.size(), 20U);
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_FALSE(std::filesystem::exists(file)) << "what it says holds no more";
}

TEST(Observability, AMetricsFileThatCannotBeWrittenIsLoggedOnceAndStopsNothingElse) {
  const TempFolder folder;
  const Daemon daemon(config_with(folder, json::array({left()}),
                                  {{"metrics", {{"file", "/nowhere/slipd.prom"}, {"period_s", 1}}}}),
                      trial_drivers());
  const std::string complaint = "/nowhere/slipd.prom cannot be written: No such file";
  daemon.wait_for_log(complaint);
  const double said_s = daemon.client().result("status")["uptime_s"];
  daemon.wait_for("status", [&](const json& s) { return s["uptime_s"] > said_s + 2.5; });
  const std::string errors = daemon.program().errors();
  const auto first = errors.find(complaint);
  EXPECT_EQ(errors.find("/nowhere/slipd.prom", first + 1), std::string::npos) << errors;
}

TEST(Observability, AFileThatSomebodyPutsInTheMetricsPlaceIsLeftAlone) {
  const TempFolder folder;
  const auto file = folder.file("slipd.prom");
  Daemon daemon(
      config_with(folder, json::array({left()}), {{"metrics", {{"file", file.string()}, {"period_s", 1}}}}),
      trial_drivers());
  daemon.wait_for("version", [&](const json&) { return std::filesystem::exists(file); });
  folder.write("other", "mine");
  std::filesystem::rename(folder.file("other"), file);
  daemon.wait_for_log("slipd did not make it");
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_EQ(text_of(file), "mine");
}

TEST(Observability, ADeviceThatFlapsIsLoggedAFewTimesOnly) {
  const TempFolder folder;
  const Daemon daemon(config_with(folder, json::array({left({{"behaviour", "vanish"}, {"after", 1}})})),
                      trial_drivers());
  const json status =
      daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["reconnects"] > 9; });
  const std::string errors = daemon.program().errors();
  std::size_t lines = 0;
  for (auto at = errors.find("the device is gone"); at != std::string::npos;
       at = errors.find("the device is gone", at + 1))
    ++lines;
  EXPECT_GE(lines, 1U);
  EXPECT_LE(lines, 5 * (1 + std::floor(status["uptime_s"].get<double>() / 60))) << "a minute: " << errors;
}

}  // namespace
}  // namespace slipd::testing
