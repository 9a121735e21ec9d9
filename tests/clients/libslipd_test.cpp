// libslipd against the real slipd: margins that expire, a slipd that stops, is killed, restarted or reloaded.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <slipd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cmath>
#include <fstream>
#include <set>
#include <thread>

#include "clients/c/slipd.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr double kPatienceS = std::chrono::duration<double>(kPatience).count();
constexpr double kAnyAge = 3600;

class Libslipd : public ::testing::Test {
 protected:
  Libslipd() { EXPECT_EQ(slipd_open(&client_, daemon_->socket().c_str()), SLIPD_DONE); }
  ~Libslipd() override { slipd_close(client_); }
  static json two_fingers(const TempFolder& folder) {
    return config_with(folder, json::array({trial_sensor("left"), trial_sensor("right", {{"gamma", 0.3}})}),
                       {{"grasps", json::array({{{"name", "cup"}, {"sensors", {"right", "left"}}}})}});
  }
  void restart() { daemon_ = std::make_unique<Daemon>(two_fingers(folder_), trial_drivers()); }
  void kill_it() {
    daemon_->program().signal(SIGKILL);
    daemon_->program().wait();
  }
  // The next estimate of slipd_wait that has this state.
  slipd_estimate awaited(const char* name, int state) {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    slipd_estimate estimate{};
    while (std::chrono::steady_clock::now() < until) {
      const int code = slipd_wait(client_, name, kAnyAge, 1, &estimate);
      if (code >= 0 && estimate.state == state) return estimate;
      if (code < 0) break;
    }
    ADD_FAILURE() << name << ": last state " << slipd_state_name(estimate.state) << " "
                  << slipd_error_text(client_);
    return estimate;
  }
  void await_alert(const char* name, int alert) {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    do ASSERT_GE(slipd_wait(client_, name, kAnyAge, 1, &now_), 0) << slipd_error_text(client_);
    while (now_.alert != alert && std::chrono::steady_clock::now() < until);
    ASSERT_EQ(now_.alert, alert);
  }
  int attach(const char* wait_for) { return slipd_attach(client_, wait_for, kPatienceS); }

  const TempFolder folder_;
  std::unique_ptr<Daemon> daemon_ = std::make_unique<Daemon>(two_fingers(folder_), trial_drivers());
  slipd_client* client_ = nullptr;
  slipd_estimate now_{};
};

TEST_F(Libslipd, SharedMemoryHasWhatTheSocketHas) {
  ASSERT_EQ(attach("left"), SLIPD_DONE) << slipd_error_text(client_);
  const slipd_estimate shared = awaited("left", SLIPD_STATE_OK);
  EXPECT_STREQ(shared.name, "left");
  EXPECT_GT(shared.gamma, 0);
  EXPECT_GT(shared.normal_n, 0);
  EXPECT_EQ(shared.simulated, 1);
  // A frame that both have: the socket's answer has its number, and memory then goes on with others.
  const auto until = std::chrono::steady_clock::now() + kPatience;
  do {
    ASSERT_EQ(slipd_latest(client_, "left", kAnyAge, &now_), SLIPD_DONE);
    slipd_estimate socket{};
    ASSERT_EQ(slipd_gamma(client_, "left", kAnyAge, kPatienceS, &socket), SLIPD_DONE);
    if (socket.sequence != now_.sequence) continue;
    EXPECT_EQ(socket.state, now_.state);
    EXPECT_EQ(socket.alert_cause, now_.alert_cause);
    EXPECT_EQ(socket.gamma, now_.gamma);
    EXPECT_EQ(socket.gamma_low, now_.gamma_low);
    EXPECT_EQ(socket.normal_n, now_.normal_n);
    EXPECT_EQ(socket.shear_n, now_.shear_n);
    EXPECT_NEAR(socket.radius_m, now_.radius_m, 1e-12);
    EXPECT_NEAR(socket.center_x_m, now_.center_x_m, 1e-12);
    EXPECT_NEAR(static_cast<double>(socket.time_ns - now_.time_ns), 0,
                50e6);  // two clocks, read one after the other
    return;
  } while (std::chrono::steady_clock::now() < until);
  FAIL() << "no frame was seen on both";
}

TEST_F(Libslipd, AGraspIsAsOldAsItsOldestFinger) {
  ASSERT_EQ(attach("cup"), SLIPD_DONE);
  awaited("cup", SLIPD_STATE_OK);
  const slipd_estimate cup = awaited("cup", SLIPD_STATE_OK);
  EXPECT_TRUE(std::isfinite(cup.gamma));
  slipd_estimate socket{};
  EXPECT_EQ(slipd_grasp(client_, "cup", kAnyAge, kPatienceS, &socket), SLIPD_DONE);
  EXPECT_STREQ(socket.name, "cup");
  EXPECT_TRUE(std::isfinite(socket.age_s));
  EXPECT_EQ(slipd_grasp(client_, "plate", kAnyAge, kPatienceS, &socket), SLIPD_REFUSED);
  EXPECT_EQ(socket.state, SLIPD_STATE_DISCONNECTED);
}

TEST_F(Libslipd, TheFirstFingerToSlideIsNamedInTheOrderOfTheConfiguration) {
  // The margin of right is 0.3, that of left 0.5: once both are known, the lower one is right's.
  const auto settled = [](const json& r) {
    const json& first = r["grasps"][0]["first"];
    const json &left = r["sensors"][0]["gamma"], &right = r["sensors"][1]["gamma"];
    return left.is_number() && left > 0.4 && right.is_number() && right < 0.4 && first.is_object() &&
           first["gamma"] < 0.4;
  };
  const json grasps = daemon_->wait_for("gamma", settled)["grasps"];
  EXPECT_EQ(grasps[0]["first"]["sensor"], "right");
}

TEST_F(Libslipd, AMarginIsGoneOnceItIsOlderThanAllowed) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  awaited("left", SLIPD_STATE_OK);
  EXPECT_EQ(slipd_latest(client_, "left", 1e-9, &now_), SLIPD_DONE);
  EXPECT_EQ(now_.state, SLIPD_STATE_STALE);
  EXPECT_TRUE(std::isnan(now_.gamma) && std::isnan(now_.gamma_low) && std::isnan(now_.grip_increase_n));
  for (const double none : {0.0, -1.0, std::nan("")}) {
    slipd_latest(client_, "left", none, &now_);
    EXPECT_EQ(now_.state, SLIPD_STATE_STALE) << none;
    slipd_gamma(client_, "left", none, kPatienceS, &now_);
    EXPECT_EQ(now_.state, SLIPD_STATE_STALE) << none;
  }
  // One that is kept expires as well.
  slipd_estimate kept{};
  ASSERT_EQ(slipd_latest(client_, "left", kAnyAge, &kept), SLIPD_DONE);
  EXPECT_EQ(slipd_margin(&kept), kept.gamma);
  kept.valid_until_ns = kept.time_ns;
  EXPECT_TRUE(std::isnan(slipd_margin(&kept)));
}

TEST_F(Libslipd, ThatThereIsNoAlertIsUnknownOnceItIsOlderThanAllowed) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  await_alert("left", SLIPD_ALERT_NONE);
  await_alert("right", SLIPD_ALERT_WARN);
  for (const auto& [name, alert] :
       {std::pair("left", SLIPD_ALERT_UNKNOWN), std::pair("right", SLIPD_ALERT_WARN)}) {
    slipd_latest(client_, name, 1e-9, &now_);
    EXPECT_EQ(now_.alert, alert) << name;
    slipd_gamma(client_, name, 1e-9, kPatienceS, &now_);
    EXPECT_EQ(now_.alert, alert) << name;
  }
}

// In a child whose clock is behind that of slipd, as in a container with a time namespace of its own.
TEST_F(Libslipd, WhatComesFromTheFutureIsNotFresh) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  awaited("left", SLIPD_STATE_OK);
  constexpr int kNotPermitted = 77;
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWTIME) != 0) _exit(kNotPermitted);
    std::ofstream("/proc/self/timens_offsets") << "monotonic -10 0\n";
    const pid_t behind = fork();  // this process itself keeps its clock
    if (behind == 0) {
      slipd_estimate now{};
      const int code = slipd_latest(client_, "left", kAnyAge, &now);
      const bool judged_now = std::isinf(slipd_heartbeat_age(client_));
      _exit(code == SLIPD_ATTACH_ANEW && now.state == SLIPD_STATE_DISCONNECTED && judged_now ? 0 : 1);
    }
    int status = 0;
    waitpid(behind, &status, 0);
    _exit(WEXITSTATUS(status));
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  if (WEXITSTATUS(status) == kNotPermitted) GTEST_SKIP() << "no time namespaces for this user";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(Libslipd, AWaitingReaderIsWokenForEachEstimateAndToldWhatItMissed) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  std::uint64_t got = 0, dropped = 0;
  ASSERT_EQ(slipd_wait(client_, "left", kAnyAge, kPatienceS, &now_), SLIPD_DONE);
  const std::uint64_t first = now_.sequence;
  while (got < 200) {
    ASSERT_EQ(slipd_wait(client_, "left", kAnyAge, kPatienceS, &now_), SLIPD_DONE);
    ++got;
    dropped += now_.dropped;
  }
  const json status =
      json::parse(slipd::client::Connection(daemon_->socket()).call("status", "{}", -1, kPatienceS));
  if (status["sensors"][0]["skipped"] == 0) {
    EXPECT_LE(got + dropped, status["sensors"][0]["estimated"]);
    EXPECT_EQ(now_.sequence - first, got + dropped);
  }
}

TEST_F(Libslipd, ReadingAndWaitingAllocateNothing) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  awaited("left", SLIPD_STATE_OK);
  const auto before = test::allocations();
  for (int i = 0; i < 50; ++i) {
    slipd_wait(client_, "left", kAnyAge, kPatienceS, &now_);
    slipd_latest(client_, "right", kAnyAge, &now_);
    slipd_latest(client_, "nobody", kAnyAge, &now_);
  }
  EXPECT_EQ(test::allocations(), before);
}

TEST_F(Libslipd, AStoppedSlipdIsStaleAndGoesOn) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  awaited("left", SLIPD_STATE_OK);
  await_alert("right", SLIPD_ALERT_WARN);
  daemon_->program().signal(SIGSTOP);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  int code = SLIPD_DONE;
  while (code == SLIPD_DONE && std::chrono::steady_clock::now() < until)
    code = slipd_latest(client_, "left", 0.05, &now_);
  EXPECT_EQ(code, SLIPD_ATTACH_ANEW);
  EXPECT_EQ(now_.state, SLIPD_STATE_DISCONNECTED);
  EXPECT_TRUE(std::isnan(now_.gamma));
  EXPECT_EQ(now_.alert, SLIPD_ALERT_UNKNOWN) << "there was none, and nobody watches";
  EXPECT_EQ(slipd_latest(client_, "right", 0.05, &now_), SLIPD_ATTACH_ANEW);
  EXPECT_EQ(now_.alert, SLIPD_ALERT_WARN) << "it stands";
  EXPECT_EQ(now_.alert_cause, SLIPD_CAUSE_MARGIN);
  EXPECT_GT(slipd_heartbeat_age(client_), 0.05);
  daemon_->program().signal(SIGCONT);
  do code = slipd_wait(client_, "left", kAnyAge, 1, &now_);
  while ((code != SLIPD_DONE || now_.state != SLIPD_STATE_OK) && std::chrono::steady_clock::now() < until);
  EXPECT_EQ(now_.state, SLIPD_STATE_OK);
}

TEST_F(Libslipd, AKilledSlipdIsToldAndItsSuccessorIsAttachedAnew) {
  ASSERT_EQ(attach("left"), SLIPD_DONE);
  awaited("left", SLIPD_STATE_OK);
  kill_it();
  int code = SLIPD_DONE;
  while (code >= 0) code = slipd_wait(client_, "left", 0.05, kPatienceS, &now_);
  EXPECT_EQ(code, SLIPD_ATTACH_ANEW);
  EXPECT_TRUE(std::isnan(now_.gamma));
  EXPECT_EQ(attach("left"), SLIPD_DISCONNECTED);
  EXPECT_THAT(slipd_error_text(client_), HasSubstr("slipd does not run here"));
  EXPECT_EQ(slipd_latest(client_, "left", kAnyAge, &now_), SLIPD_ATTACH_ANEW);
  restart();
  ASSERT_EQ(attach("left"), SLIPD_DONE) << slipd_error_text(client_);
  awaited("left", SLIPD_STATE_OK);
}

TEST_F(Libslipd, AnAlertStandsUntilASuccessorIsAttached) {
  ASSERT_EQ(attach("right"), SLIPD_DONE);
  await_alert("left", SLIPD_ALERT_NONE);
  await_alert("right", SLIPD_ALERT_WARN);
  const auto expect_it_stands = [&](const char* when) {
    EXPECT_EQ(slipd_latest(client_, "right", kAnyAge, &now_), SLIPD_ATTACH_ANEW) << when;
    EXPECT_EQ(now_.state, SLIPD_STATE_DISCONNECTED) << when;
    EXPECT_TRUE(std::isnan(now_.gamma)) << when;
    EXPECT_EQ(now_.alert, SLIPD_ALERT_WARN) << when;
    EXPECT_EQ(now_.alert_cause, SLIPD_CAUSE_MARGIN) << when;
    EXPECT_EQ(slipd_latest(client_, "left", kAnyAge, &now_), SLIPD_ATTACH_ANEW) << when;
    EXPECT_EQ(now_.alert, SLIPD_ALERT_UNKNOWN) << when;
    EXPECT_TRUE(std::isinf(slipd_heartbeat_age(client_))) << when;
  };
  kill_it();
  EXPECT_EQ(attach("right"), SLIPD_DISCONNECTED);
  expect_it_stands("while slipd is away");
  restart();
  EXPECT_EQ(attach("middle"), SLIPD_REFUSED);
  expect_it_stands("after the successor has refused");
  ASSERT_EQ(attach("right"), SLIPD_DONE) << slipd_error_text(client_);
  awaited("right", SLIPD_STATE_OK);
}

TEST_F(Libslipd, AReloadAndAnOrderlyStopAreToldAtOnce) {
  for (const int signal : {SIGHUP, SIGTERM}) {
    ASSERT_EQ(attach("left"), SLIPD_DONE) << slipd_error_text(client_);
    awaited("left", SLIPD_STATE_OK);
    daemon_->program().signal(signal);
    int code = SLIPD_DONE;
    while (code >= 0) code = slipd_wait(client_, "left", kAnyAge, kPatienceS, &now_);
    EXPECT_EQ(code, SLIPD_ATTACH_ANEW);
    EXPECT_TRUE(std::isinf(slipd_heartbeat_age(client_)));
    EXPECT_EQ(now_.state, SLIPD_STATE_DISCONNECTED);
    if (signal == SIGHUP) daemon_->wait_for_log("the new configuration is in force");
  }
  EXPECT_EQ(daemon_->program().wait(), 0);
}

TEST_F(Libslipd, ASubscriptionGoesOnAfterSlipdWasAway) {
  ASSERT_EQ(slipd_subscribe(client_, "left", 0, SLIPD_EVENT_ESTIMATE, kPatienceS), SLIPD_DONE);
  ASSERT_EQ(slipd_next(client_, kAnyAge, kPatienceS, &now_), SLIPD_DONE);
  EXPECT_STREQ(now_.name, "left");
  const int fd = slipd_fd(client_);
  kill_it();
  int code = SLIPD_DONE;
  while (code >= 0) code = slipd_next(client_, kAnyAge, kPatienceS, &now_);
  EXPECT_EQ(code, SLIPD_DISCONNECTED);
  EXPECT_EQ(now_.state, SLIPD_STATE_DISCONNECTED);
  EXPECT_EQ(slipd_next(client_, kAnyAge, kPatienceS, &now_), SLIPD_DISCONNECTED);  // a vain attempt
  restart();
  pollfd ready{fd, POLLIN, 0};
  const auto until = std::chrono::steady_clock::now() + kPatience;
  do {
    ASSERT_EQ(poll(&ready, 1, kPollPatience), 1) << "the descriptor says when to call";
    code = slipd_next(client_, kAnyAge, 0, &now_);
  } while (code != SLIPD_DONE && std::chrono::steady_clock::now() < until);
  EXPECT_EQ(code, SLIPD_DONE);
  EXPECT_EQ(slipd_fd(client_), fd);
}

TEST_F(Libslipd, RequestsGoOnAfterARestartAndSayWhatIsWrong) {
  char* text = nullptr;
  ASSERT_EQ(slipd_status(client_, kPatienceS, &text), SLIPD_DONE);
  EXPECT_EQ(json::parse(text)["sensors"].size(), 2U);
  slipd_free(text);
  kill_it();
  EXPECT_EQ(slipd_sensors(client_, kPatienceS, &text), SLIPD_DISCONNECTED);
  EXPECT_EQ(text, nullptr);
  restart();
  ASSERT_EQ(slipd_sensors(client_, kPatienceS, &text), SLIPD_DONE) << slipd_error_text(client_);
  slipd_free(text);
  EXPECT_EQ(slipd_gamma(client_, "mid\"dle", kAnyAge, kPatienceS, &now_), SLIPD_REFUSED);
  EXPECT_THAT(slipd_error_text(client_), HasSubstr("there is no sensor"));
  EXPECT_TRUE(std::isnan(now_.gamma));
  EXPECT_EQ(slipd_call(client_, "no such method", nullptr, -1, kPatienceS, &text), SLIPD_REFUSED);
  EXPECT_EQ(slipd_call(client_, "gamma", "[1", -1, kPatienceS, &text), SLIPD_INVALID);
  EXPECT_EQ(slipd_latest(client_, "left", kAnyAge, &now_), SLIPD_ATTACH_ANEW);
  EXPECT_EQ(slipd_attach(client_, "middle", kPatienceS), SLIPD_REFUSED);
}

TEST_F(Libslipd, ARecordingIsWrittenIntoTheCallersFileAndSaysIfItIsNotWhole) {
  const auto path = folder_.file("left.rec");
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  char* text = nullptr;
  ASSERT_EQ(slipd_record(client_, "left", 0.1, file, kPatienceS, &text), SLIPD_DONE)
      << slipd_error_text(client_);
  const json account = json::parse(text);
  slipd_free(text);
  EXPECT_EQ(account["bytes"], std::filesystem::file_size(path));
  EXPECT_TRUE(account["trouble"].is_null());
  const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
  EXPECT_EQ(slipd_record(client_, "left", 100, full, kPatienceS, &text), SLIPD_INVALID);
  EXPECT_THAT(slipd_error_text(client_), HasSubstr("No space left on device"));
  EXPECT_EQ(slipd_record(client_, "left", -1, file, kPatienceS, &text), SLIPD_INVALID);
  EXPECT_EQ(slipd_record(client_, "middle", 1, file, kPatienceS, &text), SLIPD_REFUSED);
  EXPECT_EQ(text, nullptr);
  EXPECT_EQ(slipd_call(client_, "version", nullptr, file, kPatienceS, &text), SLIPD_INVALID);
  EXPECT_THAT(slipd_error_text(client_), HasSubstr("takes no descriptors"));
  slipd::client::Connection connection(daemon_->socket());
  EXPECT_THAT(connection.record("left", 0.1, file, kPatienceS), HasSubstr("\"trouble\":null"));
  close(full);
  close(file);
}

// The rest of what a source does: tests/clients/push_test.py, for both clients.
TEST(Source, OfTheCppHeaderSendsFramesAndAllocatesNothingForThem) {
  const TempFolder folder;
  const json layout{{"grid", {4, 4}}, {"pitch_mm", 4}};
  const Daemon daemon(config_with(folder, json::array({{{"name", "left"},
                                                        {"driver", "push"},
                                                        {"rate_hz", 100},
                                                        {"layout", layout},
                                                        {"options", {{"max_age_ms", 10000}}}}})),
                      real_drivers());
  slipd_frames frames{.taxels = 16, .axes = 3, .unit = SLIPD_UNIT_N, .zero = SLIPD_ZERO_ZERO, .rate_hz = 100};
  slipd::client::Source source("left", frames, daemon.socket().string());
  source.connect(kPatienceS);
  const std::vector<float> frame(48, 0);
  const std::uint64_t before = test::allocations();
  for (int i = 0; i < 10; ++i) source.push(frame, 0, 0, kPatienceS);
  EXPECT_EQ(test::allocations(), before);
  daemon.wait_for("status", [](const json& status) { return status["sensors"][0]["received"] == 10; });
  EXPECT_THROW(source.push(std::span(frame).first(3)), slipd::client::Error);
  frames.taxels = 9;
  slipd::client::Source other("left", frames, daemon.socket().string());
  EXPECT_THROW(other.connect(kPatienceS), slipd::client::Error);
  frames.axes = 2;
  EXPECT_THROW(slipd::client::Source("left", frames), slipd::client::Error);
}

TEST_F(Libslipd, TheCppHeaderHasTheSame) {
  slipd::client::Connection connection(daemon_->socket());
  connection.attach("left", kPatienceS);
  slipd::client::Estimate estimate = connection.wait("left", kAnyAge, kPatienceS);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!estimate.margin() && std::chrono::steady_clock::now() < until)
    estimate = connection.wait("left", kAnyAge, kPatienceS);
  EXPECT_TRUE(estimate.margin());
  EXPECT_TRUE(estimate.is_new());
  EXPECT_EQ(estimate.state_name(), "ok");
  EXPECT_FALSE(connection.latest("left", 1e-9).margin());
  EXPECT_THROW(connection.latest("middle", kAnyAge), slipd::client::Error);
  EXPECT_THROW(connection.gamma("middle", kAnyAge, kPatienceS), slipd::client::Error);
  connection.subscribe("left", 0, SLIPD_EVENT_ESTIMATE, kPatienceS);
  EXPECT_TRUE(connection.next(kAnyAge, kPatienceS).is_new());
}

}  // namespace
}  // namespace slipd::testing
