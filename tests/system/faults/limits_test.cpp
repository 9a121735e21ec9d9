// slipd without a resource: descriptors, memory, disk space, the socket's path. Each time the error is
// reported, only the operation that needed the resource fails, and it succeeds again when the resource is
// there.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "core/storage/unique_fd.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

json fine_sensor(const std::string& name, const json& options = json::object()) {
  return trial_sensor(name, options, {{"layout", {{"grid", {20, 20}}, {"pitch_mm", 0.72}}}});
}

class Limits : public ::testing::Test {
 protected:
  void SetUp() override { await_ok(); }
  void await_ok() const {
    daemon_.wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
  }
  // A limit of the running daemon, until lift().
  void limit(__rlimit_resource what, rlim_t most) const {
    rlimit now{};
    ASSERT_EQ(prlimit(daemon_.program().pid(), what, nullptr, &now), 0);
    now.rlim_cur = std::min(most, now.rlim_max);
    ASSERT_EQ(prlimit(daemon_.program().pid(), what, &now, nullptr), 0);
  }
  void lift(__rlimit_resource what) const { limit(what, RLIM_INFINITY); }
  void expect_frames_go_on(RpcClient& client) const {
    const auto estimated = [&] {
      return client.result("status")["sensors"][0]["estimated"].get<std::uint64_t>();
    };
    const std::uint64_t before = estimated();
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (estimated() < before + 20) ASSERT_LT(std::chrono::steady_clock::now(), until);
  }

  TempFolder folder_;
  Daemon daemon_{
      config_with(folder_, json::array({fine_sensor("left")}), {{"recorder", {{"seconds", 0.05}}}}),
      trial_drivers(),
      {{"STATE_DIRECTORY", folder_.path().string()}}};
};

TEST_F(Limits, WithoutDescriptorsThoseConnectedAreServedAndTheOthersWait) {
  if (sanitized()) GTEST_SKIP() << "without a pipe to try memory with, UBSan takes every object for none";
  RpcClient old(daemon_.socket());
  old.result("version");
  limit(RLIMIT_NOFILE, 3);  // open descriptors stay open
  RpcClient waiting(daemon_.socket());
  waiting.send_line(R"({"jsonrpc":"2.0","id":1,"method":"version"})");
  EXPECT_FALSE(waiting.line(300ms));
  expect_frames_go_on(old);
  EXPECT_THAT(old.record("left", 0.1, folder_.file("r.rec")).dump(), HasSubstr("Too many open files"));
  old.result("flight");
  while (old.result("status")["recorder"]["failed"] != 1) std::this_thread::sleep_for(1ms);
  EXPECT_THAT(daemon_.program().errors(), HasSubstr("Too many open files"));
  daemon_.program().signal(SIGHUP);
  daemon_.wait_for_log("reload:");
  expect_frames_go_on(old);
  lift(RLIMIT_NOFILE);
  EXPECT_TRUE(waiting.line()) << "it is served when there is room again";
  EXPECT_TRUE(old.record("left", 0.1, folder_.file("r.rec")).contains("frames"));
}

TEST_F(Limits, StoppedAndContinuedItGoesOnWithTheNewestFrameAndAccountsForAll) {
  RpcClient client(daemon_.socket());
  const auto account = [&] { return client.result("status")["sensors"][0]; };
  const json before = account();
  for (int i = 0; i < 5; ++i) {
    daemon_.program().signal(SIGSTOP);
    std::this_thread::sleep_for(100ms);  // five times stale_after_ms
    daemon_.program().signal(SIGCONT);
    await_ok();
    expect_frames_go_on(client);
  }
  const json after = account();
  EXPECT_EQ(after["received"],
            after["estimated"].get<std::uint64_t>() + after["skipped"].get<std::uint64_t>());
  EXPECT_EQ(after["reconnects"], before["reconnects"]) << "a pause of slipd is no fault of the device";
}

rlim_t address_space(const Daemon& daemon) {
  std::ifstream statm("/proc/" + std::to_string(daemon.program().pid()) + "/statm");
  rlim_t pages = 0;
  statm >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

TEST_F(Limits, WithLittleMemoryOnlyLargeRequestsAreRefused) {
  if (sanitized()) GTEST_SKIP() << "a sanitizer needs an address space without limit";
  constexpr rlim_t kLittle = 4'000'000;  // less than the queue of a recording
  RpcClient client(daemon_.socket());
  limit(RLIMIT_AS, address_space(daemon_) + kLittle);
  const auto file = folder_.file("r.rec");
  for (int i = 0; i < 3; ++i)
    EXPECT_THAT(client.record("left", 0.1, file).dump(), HasSubstr("not enough memory"));
  for (int i = 0; i < 20; ++i) RpcClient(daemon_.socket()).result("frame", {{"sensor", "left"}});
  expect_frames_go_on(client);
  lift(RLIMIT_AS);
  EXPECT_TRUE(client.record("left", 0.1, file).contains("frames")) << "succeeds when there is more memory";
}

// slipd may end with an error, for the service manager to restart it. It must not run without serving.
TEST_F(Limits, WithoutAnyMemoryItServesOrEnds) {
  if (sanitized()) GTEST_SKIP() << "a sanitizer needs an address space without limit";
  limit(RLIMIT_AS, address_space(daemon_));
  std::vector<std::unique_ptr<RpcClient>> crowd;
  try {
    for (int i = 0; i < 60; ++i) {
      crowd.push_back(std::make_unique<RpcClient>(daemon_.socket()));
      crowd.back()->send_line(R"({"jsonrpc":"2.0","id":1,"method":"subscribe"})");
      for (int k = 0; k < 10; ++k)
        crowd.back()->send_line(R"({"jsonrpc":"2.0","id":1,"method":"frame","params":{"sensor":"left"}})");
    }
  } catch (const std::runtime_error&) {  // it has ended
  }
  auto code = daemon_.program().wait(1s);
  crowd.clear();
  if (!code) {
    lift(RLIMIT_AS);
    try {
      await_ok();
    } catch (const std::runtime_error&) {
      code = daemon_.program().wait();
      ASSERT_TRUE(code) << "it neither serves nor ends";
    }
  }
  std::printf("without any memory it %s\n", code ? "ends" : "goes on");
  if (code) {
    EXPECT_NE(*code, 0);
  }
}

TEST(Disk, ThatTakesNoModelDoesNotStopTheSensor) {
  const TempFolder folder;
  Daemon daemon(
      config_with(folder, json::array({fine_sensor("left")}), {{"estimator", {{"method", "svd-knn"}}}}),
      trial_drivers(), {{"STATE_DIRECTORY", "/dev/full"}});
  daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["estimated"] > 0; });
  EXPECT_EQ(daemon.client().result("status")["sensors"][0]["method"], "svd-knn");
  EXPECT_THAT(daemon.program().errors(), HasSubstr("is used, but not kept"));
}

TEST(TwoAtOnce, ManyStartOnOneSocketAndOneServes) {
  const TempFolder folder;
  const auto config = folder.write("c.json", config_with(folder, json::array({fine_sensor("left")})).dump());
  constexpr int kMany = 12;
  for (int round = 0; round < 2; ++round) {  // the second round starts on the files that a crash left
    std::vector<std::unique_ptr<Program>> all;
    for (int i = 0; i < kMany; ++i) {
      all.push_back(std::make_unique<Program>(
          folder, "slipd" + std::to_string(i),
          std::vector<std::string>{(program_folder() / "slipd").string(), "--config", config.string(),
                                   "--driver-dir", trial_drivers().string()}));
    }
    int serving = -1;
    const auto until = std::chrono::steady_clock::now() + kPatience;
    for (int ended = 0; ended < kMany - 1;) {
      ASSERT_LT(std::chrono::steady_clock::now(), until);
      ended = 0;
      for (int i = 0; i < kMany; ++i) {
        const auto code = all[static_cast<std::size_t>(i)]->wait(5ms);
        ended += code ? 1 : 0;
        if (!code) serving = i;
        if (code) {
          EXPECT_EQ(code, 1);
          EXPECT_THAT(all[static_cast<std::size_t>(i)]->errors(), HasSubstr("is served by another slipd"));
        }
      }
    }
    ASSERT_GE(serving, 0);
    RpcClient client(folder.file("s.sock"));
    EXPECT_EQ(client.result("status")["pid"], all[static_cast<std::size_t>(serving)]->pid());
    all[static_cast<std::size_t>(serving)]->signal(SIGKILL);
    all[static_cast<std::size_t>(serving)]->wait();
  }
}

}  // namespace
}  // namespace slipd::testing
