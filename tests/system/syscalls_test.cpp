// The system calls of slipd's real-time threads once they run: to sleep, to be woken, to wake. strace
// observes the real program.
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <map>
#include <set>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

constexpr const char* kStrace = "/usr/bin/strace";

std::string thread_named(pid_t process, const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::ifstream file(task.path() / "comm");
    std::string comm;
    std::getline(file, comm);
    if (comm == name) return task.path().filename();
  }
  throw std::runtime_error("slipd has no thread " + name);
}

constexpr std::uint64_t kFrames = 500;
const std::string kWakeOfIo = "write to anon_inode:[eventfd]";

// How often one thread makes each system call during kFrames frames or a little more; a write is listed with
// its target. Empty: strace is not permitted here.
std::map<std::string, std::uint64_t> calls_of(const std::string& thread) {
  const TempFolder folder;
  const json sensor{
      {"name", "left"}, {"driver", "trial"}, {"layout", {{"grid", {12, 12}}, {"pitch_mm", 1.2}}}};
  const Daemon daemon(config_with(folder, json::array({sensor})), trial_drivers());
  const auto estimated = [](const json& status) {
    return status["sensors"][0]["estimated"].get<std::uint64_t>();
  };
  daemon.wait_for("status", [&](const json& status) { return estimated(status) >= 20; });
  const pid_t slipd = daemon.program().pid();
  const auto log = folder.file("calls");
  Program strace(folder, "strace", {kStrace, "-q", "-o", log.string(), "-p", thread_named(slipd, thread)});
  std::uint64_t begun = 0;
  daemon.wait_for("status", [&](const json& status) {
    std::error_code error;
    const bool looking = std::filesystem::file_size(log, error) > 0 && !error;
    if (looking && begun == 0) begun = estimated(status);
    return strace.wait(std::chrono::milliseconds(0)) || (looking && estimated(status) >= begun + kFrames);
  });
  strace.signal(SIGINT);
  strace.wait();
  std::map<std::string, std::uint64_t> calls;
  std::ifstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    const auto bracket = line.find('(');
    if (bracket == std::string::npos || line.front() == '<' || line.front() == '+') continue;
    std::string call = line.substr(0, bracket);
    if (call == "write") {
      const auto fd =
          "/proc/" + std::to_string(slipd) + "/fd/" + line.substr(bracket + 1, line.find(',') - bracket - 1);
      std::error_code error;
      call += " to " + std::filesystem::read_symlink(fd, error).string();
    }
    ++calls[call];
  }
  return calls;
}

void expect_only(const std::string& thread, const std::set<std::string>& allowed) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer makes calls of its own";
  if (!std::filesystem::exists(kStrace)) GTEST_SKIP() << "strace is not installed";
  const auto calls = calls_of(thread);
  if (calls.empty()) GTEST_SKIP() << "strace may not look at other processes here";
  for (const auto& [call, times] : calls)
    EXPECT_TRUE(allowed.count(call) > 0) << thread << " makes the call " << call;
}

TEST(SystemCalls, OfEstimateAreSleepingAndWakingIo) {
  expect_only("estimate", {"futex", "restart_syscall", kWakeOfIo});
}

// Either thread may estimate.
TEST(SystemCalls, DoNotWakeIoForEachFrameWithoutASubscriber) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer makes calls of its own";
  if (!std::filesystem::exists(kStrace)) GTEST_SKIP() << "strace is not installed";
  for (const char* thread : {"estimate", "acq:left"}) {
    auto calls = calls_of(thread);
    if (calls.empty()) GTEST_SKIP() << "strace may not look at other processes here";
    EXPECT_LT(calls[kWakeOfIo], kFrames / 5) << thread;
  }
}

// The trial driver sleeps until its next frame is due; that call is the driver's own.
TEST(SystemCalls, OfAcquireAreTheDriversAndWakingEstimateAndIo) {
  expect_only("acq:left", {"futex", "restart_syscall", "clock_nanosleep", kWakeOfIo});
}

}  // namespace
}  // namespace slipd::testing
