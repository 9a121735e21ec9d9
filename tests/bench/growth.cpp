// The part of daemon-bench on the number of sensors: CPU time of slipd by thread, time from sample to shared
// memory, frames skipped and memory, for 1 to 128 sensors as so many devices and on one bus. What the frames
// themselves cost is measured apart, in this process: the same driver with the same threads and nobody who
// estimates, and the estimates alone.
#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "driver_api/driver.hpp"
#include "tests/bench/board_watch.hpp"
#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/running.hpp"
#include "tests/bench/scenes.hpp"

namespace slipd::bench {
namespace {

using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr std::size_t kLooksASecond = 100;  // at a sensor's record, at most
constexpr int kEstimates = 4000;            // of the time of one, which is the median

// So many sensors of one kind.
struct Hand {
  std::size_t sensors = 1;
  std::size_t side = 4;
  double rate_hz = 1000;
  bool bus = false;  // all of them on one device, which delivers a frame of each at every tick
  int threads = 0;   // realtime.estimate_threads
};

json sensors_of(const Hand& hand) {
  json all = json::array();
  for (std::size_t i = 0; i < hand.sensors; ++i) {
    all.push_back(
        trial("s" + std::to_string(i), hand.side, hand.rate_hz, {{"scan", hand.bus}, {"place", i}}));
    if (hand.bus) all.back()["device"] = {{"port", "bus"}};
  }
  return all;
}

// CPU time so far, s, of slipd's threads by what they do.
struct ThreadTimes {
  double acquire_s = 0, estimate_s = 0, io_s = 0, rest_s = 0;
  double all_s() const { return acquire_s + estimate_s + io_s + rest_s; }
};

ThreadTimes thread_times(pid_t pid) {
  ThreadTimes times;
  for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    std::ifstream schedstat(task.path() / "schedstat"), comm(task.path() / "comm");
    double ran_ns = 0;
    std::string name;
    schedstat >> ran_ns;
    std::getline(comm, name);
    double& sum_s = name.starts_with("acq:")                                 ? times.acquire_s
                    : name.starts_with("estimate")                           ? times.estimate_s
                    : task.path().filename().string() == std::to_string(pid) ? times.io_s
                                                                             : times.rest_s;
    sum_s += 1e-9 * ran_ns;
  }
  return times;
}

double thread_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

const DriverModule& trial_module() {
  static void* const file =
      dlopen((testing::trial_drivers() / "slipd-driver-trial.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (file == nullptr) throw std::runtime_error(dlerror());
  return *reinterpret_cast<const DriverModule* (*)()>(dlsym(file, kDriverSymbol))();
}

// A device of the driver, and memory for a frame of each of its sensors.
struct Source {
  Source(const Hand& hand, std::size_t sensors, bool burst)
      : memory(3 * hand.side * hand.side * sensors), slots(sensors) {
    const std::size_t taxels = hand.side * hand.side;
    const json options{{"behaviour", "steady"}, {"after", 0},     {"troubles", 0},     {"gate", ""},
                       {"well_until", ""},      {"account", ""},  {"gap_every", 0},    {"corrupt_every", 0},
                       {"burst", burst},        {"paced", false}, {"simulated", true}, {"gamma", 0.5},
                       {"scan", hand.bus}};
    const SensorSetup setup{.name = "s",
                            .layout = pad(hand.side),
                            .rate_hz = hand.rate_hz,
                            .profile = {},
                            .device = {},
                            .options = options};
    std::span<float> rest(memory);
    for (FrameSlot& slot : slots) {
      for (auto* part : {&slot.normal_pa, &slot.shear_x_pa, &slot.shear_y_pa}) {
        *part = rest.first(taxels);
        rest = rest.subspan(taxels);
      }
    }
    driver = trial_module().create(std::vector<SensorSetup>(sensors, setup));
    driver->open();
  }
  std::vector<float> memory;
  std::vector<FrameSlot> slots;
  std::unique_ptr<DeviceDriver> driver;
};

// Share of a core that the devices take with nobody who estimates: their clocks and the copies of their
// frames.
double devices_alone(const Hand& hand, std::chrono::nanoseconds how_long) {
  const std::size_t devices = hand.bus ? 1 : hand.sensors;
  std::vector<std::unique_ptr<Source>> sources;
  for (std::size_t i = 0; i < devices; ++i)
    sources.push_back(std::make_unique<Source>(hand, hand.bus ? hand.sensors : 1, false));
  std::vector<double> spent_s(devices);
  std::atomic<bool> stop{false};
  const std::int64_t begun_ns = now_ns();
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < devices; ++i) {
      threads.emplace_back([&, i] {
        const double before_s = thread_s();
        while (!stop.load(std::memory_order_relaxed)) sources[i]->driver->read(sources[i]->slots, 50ms);
        spent_s[i] = thread_s() - before_s;
      });
    }
    std::this_thread::sleep_for(how_long);
    stop.store(true, std::memory_order_relaxed);
  }
  double sum_s = 0;
  for (const double each : spent_s) sum_s += each;
  return sum_s / (1e-9 * static_cast<double>(now_ns() - begun_ns));
}

// What the estimate of one frame takes by itself, all of the chain.
double estimate_us(std::size_t side) {
  Source source({.side = side}, 1, true);
  EstimatorChain chain(setup_of(side, MethodChoice::moments), nullptr);
  std::vector<std::int64_t> times;
  for (int i = 0; i < kEstimates; ++i) {
    source.driver->read(source.slots, 1ms);
    source.slots[0].time_ns = std::int64_t{1'000'000} * (i + 1);
    const Frame frame = source.slots[0].view();
    const std::int64_t since = now_ns();
    benchmark::DoNotOptimize(chain.estimate(frame));
    times.push_back(now_ns() - since);
  }
  return quantiles_of(times).p50_us;
}

json counts_of(const Daemon& daemon) {
  json sums{{"received", 0}, {"skipped", 0}};
  const json status = daemon.client().result("status");
  for (const json& sensor : status["sensors"]) {
    for (auto& [name, sum] : sums.items()) sum = sum.get<std::uint64_t>() + sensor[name].get<std::uint64_t>();
  }
  return sums;
}

void measure(const Hand& hand, double one_estimate_us) {
  const auto how_long = std::chrono::nanoseconds(length(3s));
  const double alone = devices_alone(hand, how_long / 3);
  const TempFolder folder;
  json settings = config(folder, sensors_of(hand), "moments");
  settings["realtime"]["estimate_threads"] = hand.threads;
  const Daemon daemon(settings, testing::trial_drivers(), state());
  wait_for_estimates(daemon, 20);
  const pid_t pid = daemon.program().pid();
  BoardWatch watch(daemon, "s0");

  const json counts = counts_of(daemon);
  const ThreadTimes before = thread_times(pid);
  const std::int64_t begun_ns = now_ns();
  std::vector<std::int64_t> times;
  for (const SeenEstimate& each :
       watch.sample(how_long, kLooksASecond * std::max<std::size_t>(1, 16 / watch.sensors())))
    times.push_back(each.published_ns - each.sample_ns);
  const double seconds = 1e-9 * static_cast<double>(now_ns() - begun_ns);
  const ThreadTimes after = thread_times(pid);
  const json counts_after = counts_of(daemon);
  const Usage usage = usage_of(pid);

  const auto gained = [&](const char* name) {
    return counts_after[name].get<std::uint64_t>() - counts[name].get<std::uint64_t>();
  };
  json values = to_json(quantiles_of(times));
  values.update({{"sensors", hand.sensors},
                 {"side", hand.side},
                 {"rate_hz", hand.rate_hz},
                 {"way", hand.bus ? "bus" : "devices"},
                 {"threads", daemon.client().result("status")["realtime"]["estimate_threads"]},
                 {"cpu", (after.all_s() - before.all_s()) / seconds},
                 {"acquire", (after.acquire_s - before.acquire_s) / seconds},
                 {"estimate", (after.estimate_s - before.estimate_s) / seconds},
                 {"io", (after.io_s - before.io_s) / seconds},
                 {"devices_alone", alone},
                 {"estimate_us", one_estimate_us},
                 {"received", gained("received")},
                 {"skipped", gained("skipped")},
                 {"resident_mb", usage.resident_mb},
                 {"own_mb", usage.own_mb}});
  say("growth", values);
}

}  // namespace

void growth() {
  std::vector<std::size_t> numbers{1, 2, 4, 8, 16, 32, 64, 128};
  if (brief) numbers = {1, 4};
  for (const std::size_t side : {4, 16}) {
    const double one_us = estimate_us(side);
    for (const double rate_hz : {100.0, 1000.0}) {
      for (const bool bus : {false, true}) {
        for (const std::size_t sensors : numbers)
          measure({.sensors = sensors, .side = side, .rate_hz = rate_hz, .bus = bus}, one_us);
      }
    }
  }
}

// The two that the page has goals for, and beside them one sensor, and one thread for what has two by itself.
void growth_goals() {
  const Hand hands[] = {{1, 16, 1000, false},
                        {16, 16, 1000, false},
                        {1, 4, 1000, true},
                        {128, 4, 1000, true, 1},
                        {128, 4, 1000, true}};
  for (const Hand& hand : hands) measure(hand, estimate_us(hand.side));
}

}  // namespace slipd::bench
