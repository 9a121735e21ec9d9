// The part of daemon-bench on a busy machine: from the sample to the shared memory with and without real-time
// scheduling, alone and beside stress-ng, which keeps every processor, the caches, the kernel and the memory
// busy.
#include <sched.h>

#include <csignal>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

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
  explicit Load(const TempFolder& folder) : program_(folder, "stress-ng", command()) {}
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;
  ~Load() {
    program_.signal(SIGTERM);
    program_.wait();
  }

  // Throws std::runtime_error if it has ended.
  void demand_that_it_runs() {
    if (program_.wait(0ms))
      throw std::runtime_error("stress-ng ended: " + program_.errors() + "; tools/setup --bench installs it");
  }

 private:
  static std::vector<std::string> command() {
    const std::string workers = std::to_string(2 * std::thread::hardware_concurrency());
    return {"/usr/bin/env", "stress-ng", "--quiet", "--cpu",      workers, "--cache", workers, "--switch",
            workers,        "--vm",      "2",       "--vm-bytes", "256M",  "--timer", "1"};
  }

  testing::Program program_;
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
  if (loaded) load.emplace(folder);
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
  if (load) load->demand_that_it_runs();
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
