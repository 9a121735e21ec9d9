// Clients that mean harm: none of them holds slipd up, makes it large, or costs what others recorded. How
// long a reload and a stop take meanwhile is printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "core/storage/unique_fd.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

constexpr int kHostile = 60;                   // of the 64 places that there are
constexpr std::size_t kAllowedKb = 64 * 1024;  // above idle
const json kAnHour{{"sensor", "left"}, {"seconds", 3600}};

json large_sensor(const json& options = json::object()) {
  return trial_sensor("left", options, {{"rate_hz", 500}, {"stale_after_ms", 60'000}});  // 100 x 100 taxels
}

std::string frame_batch() {
  std::string batch = "[";
  for (int i = 0; i < 64; ++i)
    batch += std::string(i > 0 ? "," : "") + R"({"jsonrpc":"2.0","id":)" + std::to_string(i) +
             R"(,"method":"frame","params":{"sensor":"left"}})";
  return batch + "]\n";
}

class Hostile : public ::testing::Test {
 protected:
  void start(const json& sensor, const json& more = json::object(), const Program::Environment& set = {}) {
    daemon_ =
        std::make_unique<Daemon>(config_with(folder_, json::array({sensor}), more), trial_drivers(), set);
    daemon_->wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
  }
  // Sends the signal and waits for what it has to bring about.
  template <typename Done>
  void timed(const char* what, int signal, Done done) {
    const auto begin = std::chrono::steady_clock::now();
    daemon_->program().signal(signal);
    done();
    std::printf("%s: %.0f ms\n", what,
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  void expect_reload_and_stop() {
    timed("reload", SIGHUP, [&] { daemon_->wait_for_log("the new configuration is in force"); });
    timed("stop", SIGTERM, [&] { EXPECT_EQ(daemon_->program().wait(), 0); });
    EXPECT_FALSE(std::filesystem::exists(daemon_->socket()));
  }

  TempFolder folder_;
  std::unique_ptr<Daemon> daemon_;
};

TEST_F(Hostile, ThatReadNothingAreNotReadFromAndMakeItLittleLarger) {
  start(large_sensor());
  RpcClient good(daemon_->socket());
  good.result("frame", {{"sensor", "left"}});
  const std::size_t idle_kb = resident_kb(daemon_->program().pid());
  const std::string batch = frame_batch();
  std::vector<std::unique_ptr<RpcClient>> hostile;
  std::vector<std::jthread> sending;
  RpcClient recording(daemon_->socket());
  recording.result("record", kAnHour);
  const Copying file(recording.take_descriptor(), folder_.file("r.rec"));
  for (int i = 0; i < kHostile; ++i) {
    hostile.push_back(std::make_unique<RpcClient>(daemon_->socket()));
    hostile.back()->send_line(R"({"jsonrpc":"2.0","method":"subscribe","params":{"max_rate_hz":)" +
                              std::to_string(5 + i) + "}}");
    sending.emplace_back([&client = *hostile.back(), &batch] {
      for (int k = 0; k < 16 && client.send(batch); ++k) {
      }
    });
  }
  std::size_t most_kb = 0;
  json socket;
  daemon_->wait_for("status", [&](const json& status) {
    most_kb = std::max(most_kb, resident_kb(daemon_->program().pid()));
    socket = status["outputs"]["socket"];
    return socket["refused"] > kHostile && socket["held_back"] > 0;
  });
  for (int i = 0; i < 500; ++i) {
    good.result("gamma");
    most_kb = std::max(most_kb, resident_kb(daemon_->program().pid()));
  }
  std::printf("resident: %zu kB idle, at most %zu kB; owed %s, held back %s, refused %s\n", idle_kb, most_kb,
              socket["owed_bytes"].dump().c_str(), socket["held_back"].dump().c_str(),
              socket["refused"].dump().c_str());
  if (!sanitized()) {
    EXPECT_LE(most_kb, idle_kb + kAllowedKb);
  }
  // One of them reads at last: it gets every answer.
  json answers;
  while (!answers.is_array()) {  // after notifications
    const auto line = hostile.front()->line();
    ASSERT_TRUE(line);
    answers = json::parse(*line);
  }
  ASSERT_EQ(answers.size(), 64U);
  EXPECT_TRUE(
      std::any_of(answers.begin(), answers.end(), [](const json& a) { return a.contains("result"); }));
  EXPECT_TRUE(std::any_of(answers.begin(), answers.end(),
                          [](const json& a) { return a.contains("error") && a["error"]["code"] == -32004; }));
  expect_reload_and_stop();
}

TEST_F(Hostile, ThatDoNotReadTheirRecordingEndItAndAreToldWhatDidNotFit) {
  start(large_sensor());
  RpcClient client(daemon_->socket());
  client.result("record", kAnHour);
  const UniqueFd unread = client.take_descriptor();
  const json told = client.notification();
  EXPECT_EQ(told["method"], "recorded");
  EXPECT_THAT(told["params"]["trouble"].get<std::string>(), HasSubstr("took nothing"));
  EXPECT_GT(told["params"]["missed"], 0);
  EXPECT_EQ(client.result("version")["name"], "slipd");
  daemon_->wait_for("status", [](const json& s) { return s["recordings"]["failed"] == 1; });
}

TEST_F(Hostile, ThatReadTheirRecordingByteByByteHoldUpNeitherReloadNorStop) {
  start(large_sensor());
  RpcClient client(daemon_->socket());
  client.result("record", kAnHour);
  const UniqueFd reading = client.take_descriptor();
  std::jthread sipping([&](const std::stop_token& stop) {
    char byte = 0;
    while (!stop.stop_requested() && recv(reading.get(), &byte, 1, 0) == 1) {
    }
  });
  for (int i = 0; i < 200; ++i) RpcClient(daemon_->socket()).result("gamma");
  expect_reload_and_stop();
  shutdown(reading.get(), SHUT_RD);
}

// What is on its way to a reader is memory of slipd's.
TEST_F(Hostile, ThatLeaveRecordingsUnreadGetNoMoreUntilTheyRead) {
  constexpr int kSensors = 8, kMost = 16;
  const json small{{"layout", {{"grid", {4, 4}}, {"pitch_mm", 4}}}, {"stale_after_ms", 60'000}};
  json sensors = json::array();
  for (int i = 0; i < kSensors; ++i)
    sensors.push_back(trial_sensor("s" + std::to_string(i), json::object(), small));
  Daemon daemon(config_with(folder_, sensors), trial_drivers());
  RpcClient client(daemon.socket());
  std::vector<UniqueFd> unread;
  const auto ask = [&](int i) {
    return client.call("record", {{"sensor", "s" + std::to_string(i % kSensors)}, {"seconds", 0.001}});
  };
  while (unread.size() < kMost) {
    for (int i = 0; i < kSensors; ++i) {
      const json answer = ask(i);
      ASSERT_TRUE(answer.contains("result")) << answer;
      unread.push_back(client.take_descriptor());
    }
    for (int i = 0; i < kSensors; ++i)
      EXPECT_THAT(client.notification()["params"]["trouble"].get<std::string>(), HasSubstr("took nothing"));
  }
  const json refused = ask(0);
  EXPECT_EQ(refused["error"]["code"], -32003);
  EXPECT_THAT(refused.dump(), HasSubstr("have not read them to the end"));
  copy_to_end(std::move(unread.front()), folder_.file("r.rec"));
  EXPECT_GT(std::filesystem::file_size(folder_.file("r.rec")), 0U);
  EXPECT_TRUE(ask(0).contains("result"));
}

TEST_F(Hostile, ThatNameASensorAgainAndAgainInSubscriptionsMakeItLittleLarger) {
  constexpr int kNaming = 4, kSubscriptions = 16, kNames = 16'000;
  constexpr std::size_t kFewKb = 12 * 1024;  // of which one line and its values take a part
  Daemon daemon(config_with(folder_, json::array({trial_sensor("a")})), trial_drivers());
  const json params{{"sensors", std::vector<std::string>(kNames, "a")}};
  std::vector<std::unique_ptr<RpcClient>> hostile;
  const std::size_t idle_kb = resident_kb(daemon.program().pid());
  for (int i = 0; i < kNaming; ++i) {
    hostile.push_back(std::make_unique<RpcClient>(daemon.socket()));
    for (int k = 0; k < kSubscriptions; ++k) hostile.back()->result("subscribe", params);
  }
  const std::size_t kb = resident_kb(daemon.program().pid());
  std::printf("resident: %zu kB idle, %zu kB with the subscriptions\n", idle_kb, kb);
  if (!sanitized()) {
    EXPECT_LE(kb, idle_kb + kFewKb);
  }
  EXPECT_EQ(hostile.back()->notification()["params"]["sensor"], "a");
}

std::size_t files_ending(const std::filesystem::path& folder, const std::string& ending) {
  std::size_t count = 0;
  for (const auto& item : std::filesystem::directory_iterator(folder)) {
    if (item.path().string().ends_with(ending)) ++count;
  }
  return count;
}

TEST_F(Hostile, RequestsForTheFlightRecorderCostNoRecordingOfASlip) {
  const TempFolder state;
  constexpr int kKeep = 2;
  start(trial_sensor("left", {{"gamma", 0.05}}, {{"rate_hz", 200}, {"stale_after_ms", 60'000}}),
        {{"recorder", {{"seconds", 0.05}, {"keep", kKeep}}}}, {{"STATE_DIRECTORY", state.path().string()}});
  const auto folder = state.file("recordings");
  daemon_->wait_for("status", [&](const json& s) { return s["recorder"]["kept"] >= 1; });
  ASSERT_EQ(files_ending(folder, "-slip.rec"), 1U);
  RpcClient client(daemon_->socket());
  daemon_->wait_for("status", [&](const json& s) {
    client.call("flight");
    return s["recorder"]["kept"] >= 2 * kKeep + 3;
  });
  EXPECT_EQ(files_ending(folder, "-slip.rec"), 1U);
  EXPECT_LE(files_ending(folder, "-request.rec"), static_cast<std::size_t>(kKeep) + 1)
      << "one is being added";
}

}  // namespace
}  // namespace slipd::testing
