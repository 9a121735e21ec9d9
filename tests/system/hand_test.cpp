// Many sensors, estimated by several threads: each sensor and grasp is estimated, and all threads are
// watched.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "clients/c/slipd.h"
#include "tests/support/daemon.hpp"
#include "tests/support/notify_socket.hpp"
#include "tests/support/subscriber.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::IsSupersetOf;
using namespace std::chrono_literals;

constexpr double kAnyAge = 10;  // s

// Sensors with a contact that holds, "s0", "s1", ….
json sensors(std::size_t count) {
  const json more{{"rate_hz", 200}, {"layout", {{"grid", {8, 8}}, {"pitch_mm", 1.8}}}, {"friction", 0.5}};
  json all = json::array();
  for (std::size_t i = 0; i < count; ++i)
    all.push_back(trial_sensor("s" + std::to_string(i), {{"gamma", 0.5}}, more));
  return all;
}

std::set<std::string> thread_names(pid_t process) {
  std::set<std::string> names;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    names.insert(name);
  }
  return names;
}

TEST(Hand, EachSensorAndGraspIsEstimatedWhicheverThreadHasIt) {
  const TempFolder folder;
  const json grasps{{{"name", "near"}, {"sensors", {"s0", "s5"}}},
                    {{"name", "far"}, {"sensors", {"s1", "s2"}}}};
  const Daemon daemon(
      config_with(folder, sensors(8), {{"grasps", grasps}, {"realtime", {{"estimate_threads", 3}}}}),
      trial_drivers());
  const auto all_well = [](const json& of) {
    return std::all_of(of.begin(), of.end(), [](const json& each) { return each["state"] == "ok"; });
  };
  const json now = daemon.wait_for(
      "gamma", [&](const json& r) { return all_well(r["sensors"]) && all_well(r["grasps"]); });
  for (const json& each : now["sensors"]) EXPECT_NEAR(each["gamma"], 0.5, 0.1) << each["sensor"];
  for (const json& each : now["grasps"]) EXPECT_NEAR(each["gamma"], 0.5, 0.1) << each["grasp"];
  EXPECT_EQ(daemon.client().result("status")["realtime"]["estimate_threads"], 3);
  EXPECT_THAT(thread_names(daemon.program().pid()), IsSupersetOf({"estimate", "estimate 2", "estimate 3"}));

  Subscriber all(daemon.socket());
  const auto behind = [&] {
    const auto& counts = all.counts();
    return counts.size() < 8 || std::any_of(counts.begin(), counts.end(),
                                            [](const auto& each) { return each.second.frames < 100; });
  };
  while (behind()) ASSERT_TRUE(all.read(kPatience));
  EXPECT_EQ(all.broken_lines(), 0U);
}

TEST(Hand, AGraspOfAllSensorsLeavesOneThreadToEstimate) {
  const TempFolder folder;
  const json grasps{{{"name", "cup"}, {"sensors", {"s0", "s1", "s2"}}}};
  const Daemon daemon(
      config_with(folder, sensors(3), {{"grasps", grasps}, {"realtime", {{"estimate_threads", 3}}}}),
      trial_drivers());
  daemon.wait_for("gamma", [](const json& r) { return r["grasps"][0]["state"] == "ok"; });
  EXPECT_EQ(daemon.client().result("status")["realtime"]["estimate_threads"], 1);
}

// Its second thread stands still, and the first goes on.
class HalfHungHand : public ::testing::Test {
 protected:
  HalfHungHand() {
    EXPECT_TRUE(says("READY=1"));
    slipd_open(&client_, config_["socket"]["path"].get_ref<const std::string&>().c_str());
    EXPECT_EQ(slipd_attach(client_, nullptr, kAnyAge), SLIPD_DONE);
  }
  ~HalfHungHand() override { slipd_close(client_); }
  // Waits until slipd says this to its manager. False: it has ended before.
  bool says(const char* text) {
    while (!manager_.says(text, 100ms)) {
      if (slipd_.wait(0ms)) return false;
    }
    return true;
  }
  int latest(const char* sensor) {
    slipd_estimate now;
    return slipd_latest(client_, sensor, 1e-9, &now);
  }
  TempFolder folder_;
  NotifySocket manager_{folder_.file("notify")};
  json config_ = config_with(folder_, sensors(2), {{"realtime", {{"estimate_threads", 2}}}});
  Program slipd_{folder_,
                 "slipd",
                 {(program_folder() / "slipd").string(), "--config",
                  folder_.write("c.json", config_.dump()).string(), "--driver-dir", trial_drivers().string()},
                 {{"NOTIFY_SOCKET", folder_.file("notify").string()}, {"WATCHDOG_USEC", "1000000"}}};
  slipd_client* client_ = nullptr;
};

TEST_F(HalfHungHand, IsSeenByReadersOfEachSensorAndByTheWatchdog) {
  ASSERT_TRUE(says("WATCHDOG=1"));
  Program holder(folder_, "holder",
                 {(std::filesystem::path(SLIPD_BINARY_DIR) / "test-bin/stop-thread").string(),
                  std::to_string(slipd_.pid()), "estimate 2"});
  while (holder.output().find("stopped") == std::string::npos) {
    if (holder.wait(10ms)) GTEST_SKIP() << "threads may not be stopped here: root may";
  }
  while (slipd_heartbeat_age(client_) < 1) ASSERT_FALSE(slipd_.wait(10ms));
  EXPECT_EQ(latest("s0"), SLIPD_ATTACH_ANEW);
  EXPECT_EQ(latest("s1"), SLIPD_ATTACH_ANEW);
  manager_.forget();
  const auto until = std::chrono::steady_clock::now() + 1500ms;  // it is fed twice a second else
  while (std::chrono::steady_clock::now() < until) EXPECT_FALSE(manager_.says("WATCHDOG=1", 100ms));

  holder.signal(SIGKILL);
  ASSERT_TRUE(says("WATCHDOG=1"));
  while (slipd_heartbeat_age(client_) > 0.1) ASSERT_FALSE(slipd_.wait(10ms));
}

}  // namespace
}  // namespace slipd::testing
