// The part of daemon-bench on a busy machine: from the sample to the shared memory with and without real-time
// scheduling, alone and beside stress-ng, which keeps every processor, the caches, the kernel and the memory
// busy.
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "tests/bench/board_watch.hpp"
#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/running.hpp"

namespace slipd::bench {
namespace {

using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;

constexpr std::size_t kSide = 16;
constexpr double kRateHz = 1000;
constexpr auto kLooksEachSecond = static_cast<std::size_t>(4 * kRateHz);
constexpr int kWatchPriority = 70;  // above slipd's 60: it sleeps nearly always

// stress-ng until it is destroyed: two of each kind for every processor.
class Load {
 public:
  Load() {
    const std::string workers = std::to_string(2 * std::thread::hardware_concurrency());
    std::vector<std::string> words{"stress-ng",  "--quiet",  "--cpu",   workers, "--cache",
                                   workers,      "--switch", workers,   "--vm",  "2",
                                   "--vm-bytes", "256M",     "--timer", "1"};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int failed = posix_spawnp(&pid_, "stress-ng", nullptr, nullptr, arguments.data(), environ);
    if (failed != 0)
      throw std::runtime_error(std::string("stress-ng: ") + std::strerror(failed) +
                               "; tools/setup --bench installs it");
  }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;
  ~Load() {
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }

 private:
  pid_t pid_ = 0;
};

void watch_as_real_time() {
  const sched_param priority{.sched_priority = kWatchPriority};
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority) != 0)
    throw std::runtime_error("no real-time scheduling here: run as root, or with a limit rtprio of 70");
}

json sensor_of(const Daemon& daemon) {
  return daemon.client().result("status")["sensors"][0];
}

void measure_beside(bool real_time, bool loaded) {
  const TempFolder folder;
  const Daemon daemon(config(folder, json::array({trial("left", kSide, kRateHz)}), "moments",
                             {{"realtime", {{"mode", real_time ? "enforce" : "off"}}}}),
                      testing::trial_drivers(), state());
  wait_for_estimates(daemon, 100);
  BoardWatch watch(daemon, "left");
  std::optional<Load> load;
  if (loaded) load.emplace();
  const auto how_long = std::chrono::nanoseconds(length(60s));
  const json before = sensor_of(daemon);
  std::vector<SeenEstimate> estimates;
  std::exception_ptr failed;
  std::thread([&] {
    try {
      watch_as_real_time();
      estimates = watch.sample(how_long, kLooksEachSecond);
    } catch (...) {
      failed = std::current_exception();
    }
  }).join();
  if (failed) std::rethrow_exception(failed);
  const json after = sensor_of(daemon);

  std::vector<std::int64_t> times, apart;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    times.push_back(estimates[i].published_ns - estimates[i].sample_ns);
    if (i > 0 && estimates[i].number == estimates[i - 1].number + 1)
      apart.push_back(estimates[i].sample_ns - estimates[i - 1].sample_ns);
  }
  json values = to_json(quantiles_of(times));
  values["samples_apart"] = to_json(quantiles_of(apart));
  values.update({{"real_time", real_time}, {"loaded", loaded}, {"seen", estimates.size()}});
  for (const char* count : {"received", "estimated", "skipped", "lost"})
    values[count] = after[count].get<std::uint64_t>() - before[count].get<std::uint64_t>();
  say("stressed", values);
}

}  // namespace

void stressed() {
  for (const bool loaded : {false, true}) {
    for (const bool real_time : {false, true}) measure_beside(real_time, loaded);
  }
}

}  // namespace slipd::bench
