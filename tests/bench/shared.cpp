// The part of daemon-bench on the board in shared memory: what reading a record costs beside copying its
// bytes and a GET of Redis, how long after a frame a waiting reader has its estimate, beside a subscriber of
// the socket and a bare futex, and what readers cost slipd.
#include <benchmark/benchmark.h>
#include <slipd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "clients/c/board_view.hpp"
#include "daemon/board/shared_board.hpp"
#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/floors.hpp"
#include "tests/bench/load.hpp"
#include "tests/bench/redis.hpp"
#include "tests/bench/running.hpp"
#include "tests/support/subscriber.hpp"

namespace slipd::bench {
namespace {

using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;

constexpr int kTurns = 5;        // of what is compared, one after the other
constexpr double kPatience = 5;  // s

// ns of one call, the least of several runs: others use the machine as well.
double cost_ns(const std::function<void()>& call) {
  constexpr int kCalls = 2000, kRuns = 50;
  double least = 1e300;
  for (int run = 0; run < (brief ? 2 : kRuns); ++run) {
    const std::int64_t begin = now_ns();
    for (int i = 0; i < kCalls; ++i) call();
    least = std::min(least, static_cast<double>(now_ns() - begin) / kCalls);
  }
  return least;
}

void reads(slipd_client* client) {
  SharedBoard board;
  SharedBoard::Writer writer(board);
  board.open({"left"}, {});
  bool is_new = false;
  writer.begin_round(now_ns(), is_new);
  client::BoardView view;
  if (const std::string why = view.map(board.descriptor()); !why.empty()) throw std::runtime_error(why);
  Estimate estimate;
  estimate.state = State::ok;
  estimate.gamma = 0.5;
  std::array<board_layout::Record, 2> copies;
  slipd_estimate now;
  json values{{"bytes", sizeof(board_layout::Record)}};
  values["memcpy_ns"] = cost_ns([&] {
    benchmark::DoNotOptimize(copies.data());
    std::memcpy(&copies[1], &copies[0], sizeof copies[0]);
    benchmark::ClobberMemory();
  });
  values["record_ns"] = cost_ns([&] { benchmark::DoNotOptimize(view.record(0)); });
  values["latest_ns"] = cost_ns([&] { slipd_latest(client, "left", 1, &now); });
  values["write_ns"] = cost_ns([&] { writer.publish_sensor(0, estimate, false); });
  const auto attachment = board.wait_for({0});
  values["write_and_wake_nobody_ns"] = cost_ns([&] { writer.publish_sensor(0, estimate, false); });
  say("shared reads", values);
}

// Of the latest estimate by one reader, without a pause.
double reads_per_s(slipd_client* client, std::chrono::nanoseconds how_long) {
  constexpr int kBetweenLooks = 100;
  slipd_estimate now;
  std::uint64_t reads = 0;
  const std::int64_t begin = now_ns(), until = begin + how_long.count();
  std::int64_t end = begin;
  for (; end < until; end = now_ns()) {
    for (int i = 0; i < kBetweenLooks; ++i) slipd_latest(client, "left", 1, &now);
    reads += kBetweenLooks;
  }
  return static_cast<double>(reads) / (1e-9 * static_cast<double>(end - begin));
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The same number by shared memory and by GETs of one client, in turn.
void rates(slipd_client* client) {
  const auto redis = Redis::start();
  if (redis) redis->set(std::string(sizeof(board_layout::Record), 'x'));
  const auto each = std::chrono::duration_cast<std::chrono::milliseconds>(length(5s)) / (2 * kTurns);
  std::vector<double> ours, theirs;
  for (int turn = 0; turn < kTurns; ++turn) {
    ours.push_back(reads_per_s(client, each));
    if (redis)
      theirs.push_back(
          ask_for({.socket = redis->socket(), .request = kRedisGet, .newlines = 2}, each).per_second);
  }
  say("shared rate", {{"server", "slipd"}, {"per_s", median_of(ours)}});
  if (redis) say("shared rate", {{"server", "redis"}, {"per_s", median_of(theirs)}});
}

// From the sample to the estimate in the hands of a reader that waits for it.
std::vector<std::int64_t> waited(slipd_client* client, std::chrono::nanoseconds how_long) {
  std::vector<std::int64_t> times;
  slipd_estimate now;
  const std::int64_t until = now_ns() + how_long.count();
  while (now_ns() < until) {
    if (slipd_wait(client, "left", kPatience, kPatience, &now) == SLIPD_DONE)
      times.push_back(now_ns() - now.time_ns);
  }
  return times;
}

std::vector<std::int64_t> subscribed(const Daemon& daemon, std::chrono::nanoseconds how_long) {
  testing::Subscriber subscriber(daemon.socket());
  subscriber.keep_latencies();
  const std::int64_t until = now_ns() + how_long.count();
  while (now_ns() < until && subscriber.read(1s)) {
  }
  std::vector<std::int64_t> times;
  for (const double us : subscriber.take_latencies().delivered_us)
    times.push_back(static_cast<std::int64_t>(1e3 * us));
  return times;
}

void delivery(const Daemon& daemon, slipd_client* client, std::size_t side) {
  std::vector<std::int64_t> reader, socket;
  const auto each = std::chrono::nanoseconds(length(10s)) / (2 * kTurns);
  for (int turn = 0; turn < kTurns; ++turn) {
    for (const auto ns : waited(client, each)) reader.push_back(ns);
    for (const auto ns : subscribed(daemon, each)) socket.push_back(ns);
  }
  json values{{"side", side},
              {"reader", to_json(quantiles_of(reader))},
              {"subscriber", to_json(quantiles_of(socket))},
              {"futex wake", to_json(futex_wake(length(1s)))}};
  say("shared delivery", values);
}

// Readers in threads of their own, during its lifetime: each looks a hundred times a second, or is woken for
// each estimate.
class Readers {
 public:
  Readers(const Daemon& daemon, int looking, int waiting) {
    for (int i = 0; i < looking + waiting; ++i) {
      all_.emplace_back([&daemon, waits = i >= looking](const std::stop_token& stop) {
        slipd_client* client = nullptr;
        slipd_open(&client, daemon.socket().c_str());
        slipd_attach(client, waits ? "left" : nullptr, kPatience);
        slipd_estimate now;
        while (!stop.stop_requested()) {
          if (waits) {
            slipd_wait(client, "left", 1, 0.1, &now);
          } else {
            slipd_latest(client, "left", 1, &now);
            std::this_thread::sleep_for(10ms);
          }
        }
        slipd_close(client);
      });
    }
  }

 private:
  std::vector<std::jthread> all_;
};

// CPU time of slipd at 1 kHz beside readers and without any, in turn; shares of a core.
void readers(const Daemon& daemon) {
  const auto cpu_share = [&] {
    std::this_thread::sleep_for(length(500ms));  // until all are attached
    const double before_s = thread_cpu_s(daemon.program().pid());
    const std::int64_t begin = now_ns();
    std::this_thread::sleep_for(length(2s));
    return (thread_cpu_s(daemon.program().pid()) - before_s) / (1e-9 * static_cast<double>(now_ns() - begin));
  };
  for (const auto& [looking, waiting] : {std::pair{100, 0}, {0, 1}, {0, 4}, {0, 20}}) {
    std::vector<double> alone, beside;
    for (int turn = 0; turn < kTurns; ++turn) {
      alone.push_back(cpu_share());
      const Readers some(daemon, looking, waiting);
      beside.push_back(cpu_share());
    }
    say("shared readers", {{"looking", looking},
                           {"waiting", waiting},
                           {"cpu_alone", median_of(alone)},
                           {"cpu", median_of(beside)}});
  }
}

}  // namespace

void shared() {
  for (const std::size_t side : {4, 100}) {
    const TempFolder folder;
    const Daemon daemon(config(folder, json::array({trial("left", side, 1000)}), "moments"),
                        testing::trial_drivers(), state());
    wait_for_estimates(daemon, 100);
    slipd_client* client = nullptr;
    slipd_open(&client, daemon.socket().c_str());
    if (slipd_attach(client, "left", kPatience) != SLIPD_DONE)
      throw std::runtime_error(slipd_error_text(client));
    delivery(daemon, client, side);
    if (side == 100) {
      reads(client);
      rates(client);
    }
    slipd_close(client);
    if (side == 100) readers(daemon);
  }
}

}  // namespace slipd::bench
