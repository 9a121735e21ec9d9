// Clients that mean harm: none of them holds slipd up, makes it large, or costs what others recorded. How
// long a reload and a stop take meanwhile is printed.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <thread>

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

std::string record_request(double seconds) {
  return R"({"jsonrpc":"2.0","id":"r","method":"record","params":{"sensor":"left","seconds":)" +
         std::to_string(seconds) + "}}\n";
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
  const UniqueFd file(open(folder_.file("r.rec").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  RpcClient recording(daemon_->socket());
  recording.send(record_request(3600), file.get());
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

struct Pipe {
  Pipe() {
    if (pipe2(ends_, O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
    reading = UniqueFd(ends_[0]);
    writing = UniqueFd(ends_[1]);
  }
  UniqueFd reading, writing;

 private:
  int ends_[2] = {-1, -1};
};

TEST_F(Hostile, APipeThatNobodyReadsEndsTheRecordingWithWhatDidNotFit) {
  start(large_sensor());
  const Pipe pipe;
  RpcClient client(daemon_->socket());
  client.send(record_request(3600), pipe.writing.get());
  const auto answer = client.line();
  ASSERT_TRUE(answer);
  EXPECT_THAT(*answer, HasSubstr("took nothing"));
  EXPECT_THAT(*answer, HasSubstr("more did not fit"));
  EXPECT_EQ(client.result("version")["name"], "slipd");
}

// The pipe blocks, and a thread of the client fills it whenever slipd finds room in it: a write may then wait
// without end.
TEST_F(Hostile, APipeThatAClientFillsMeanwhileHoldsUpNeitherReloadNorStop) {
  start(large_sensor());
  const Pipe pipe;
  RpcClient client(daemon_->socket());
  client.send(record_request(3600), pipe.writing.get());
  std::atomic<bool> over{false};
  std::thread filling([&] {
    const Pipe own;  // its flags are its own, the pipe's stay blocking
    char bytes[4096] = {};
    const UniqueFd another(::open(("/proc/self/fd/" + std::to_string(pipe.writing.get())).c_str(),
                                  O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    const UniqueFd draining(::open(("/proc/self/fd/" + std::to_string(pipe.reading.get())).c_str(),
                                   O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    while (!over) {
      if (::read(draining.get(), bytes, 5000 % sizeof bytes) < 0) std::this_thread::yield();
      while (::write(another.get(), bytes, sizeof bytes) > 0 && !over) {
      }
    }
  });
  for (int i = 0; i < 200; ++i) RpcClient(daemon_->socket()).result("gamma");
  expect_reload_and_stop();
  over = true;
  filling.join();
}

TEST_F(Hostile, WhatIsNeitherFileNorPipeNorSocketIsNotRecordedInto) {
  start(large_sensor());
  RpcClient client(daemon_->socket());
  for (const char* name : {"/dev/null", "/dev/full"}) {
    const UniqueFd device(open(name, O_WRONLY | O_CLOEXEC));
    const json answer = client.call("record", {{"sensor", "left"}, {"seconds", 1}}, device.get());
    EXPECT_EQ(answer["error"]["code"], -32602) << answer;
    EXPECT_THAT(answer.dump(), HasSubstr("neither a regular file, a pipe nor a socket"));
  }
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
