// The part of daemon-bench on frames from a program: from the sample to the estimate of a reader that waits,
// and slipd's CPU time, beside a device in the daemon whose frames are the same.
#include <slipd.h>

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/running.hpp"

namespace slipd::bench {
namespace {

using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;

constexpr double kPushRateHz = 1000;
constexpr int kPushTurns = 3;
constexpr double kPushPatienceS = 10;

struct Measured {
  std::vector<std::int64_t> times;  // from sample to reader, ns
  double cpu_s = 0, seconds = 0;    // of slipd
  json sensor;                      // its status at the end
};

// While frames come: what a reader that waits sees for this long.
void read_estimates(const Daemon& daemon, std::chrono::nanoseconds how_long, Measured& measured) {
  slipd_client* client = nullptr;
  slipd_open(&client, daemon.socket().c_str());
  if (slipd_attach(client, "left", kPushPatienceS) != SLIPD_DONE)
    throw std::runtime_error(slipd_error_text(client));
  const double before_s = usage_of(daemon.program().pid()).cpu_s;
  const std::int64_t begun_ns = now_ns();
  slipd_estimate now;
  while (now_ns() - begun_ns < how_long.count()) {
    if (slipd_wait(client, "left", kPushPatienceS, kPushPatienceS, &now) == SLIPD_DONE)
      measured.times.push_back(now_ns() - now.time_ns);
  }
  measured.seconds += 1e-9 * static_cast<double>(now_ns() - begun_ns);
  measured.cpu_s += usage_of(daemon.program().pid()).cpu_s - before_s;
  measured.sensor = daemon.client().result("status")["sensors"][0];
  slipd_close(client);
}

// Sends the frame at the sensor's rate, by absolute time, until it is destroyed.
std::jthread program(const Daemon& daemon, const std::vector<float>& frame) {
  return std::jthread([&daemon, &frame](const std::stop_token& stop) {
    slipd_source* source = nullptr;
    const slipd_frames frames{.taxels = static_cast<std::uint32_t>(frame.size() / 3),
                              .axes = 3,
                              .unit = SLIPD_UNIT_PA,
                              .zero = SLIPD_ZERO_ZERO,
                              .rate_hz = kPushRateHz};
    slipd_source_open(&source, "left", daemon.socket().c_str(), &frames);
    slipd_source_connect(source, kPushPatienceS);
    const auto period = std::chrono::duration_cast<std::chrono::nanoseconds>(1s / kPushRateHz);
    for (auto due = std::chrono::steady_clock::now(); !stop.stop_requested(); due += period) {
      std::this_thread::sleep_until(due);
      slipd_push(source, frame.data(), 0, 0, kPushPatienceS);
    }
    slipd_source_close(source);
  });
}

// x, y and z of each taxel of the newest frame.
std::vector<float> newest_frame(const Daemon& daemon) {
  const json frame = daemon.client().result("frame", {{"sensor", "left"}});
  std::vector<float> values;
  for (std::size_t i = 0; i < frame["normal_pa"].size(); ++i) {
    for (const char* channel : {"shear_x_pa", "shear_y_pa", "normal_pa"})
      values.push_back(frame[channel][i].get<float>());
  }
  return values;
}

json to_json(const Measured& measured) {
  json values = to_json(quantiles_of(measured.times));
  values["cpu"] = measured.cpu_s / measured.seconds;
  for (const char* count : {"received", "estimated", "skipped", "lost", "corrupt"})
    values[count] = measured.sensor[count];
  return values;
}

void compare(std::size_t side) {
  Measured device, pushed;
  const auto each = std::chrono::nanoseconds(length(12s)) / kPushTurns;
  for (int turn = 0; turn < kPushTurns; ++turn) {
    const TempFolder folder;
    json sensor = trial("left", side, kPushRateHz);
    std::vector<float> frame;
    {
      const Daemon daemon(config(folder, json::array({sensor}), "moments"), testing::trial_drivers(),
                          state());
      wait_for_estimates(daemon, 100);
      frame = newest_frame(daemon);
      read_estimates(daemon, each, device);
    }
    sensor["driver"] = "push";
    const Daemon daemon(config(folder, json::array({sensor}), "moments"), testing::real_drivers(), state());
    const std::jthread sends = program(daemon, frame);
    wait_for_estimates(daemon, 100);
    read_estimates(daemon, each, pushed);
  }
  say("push", {{"side", side}, {"device", to_json(device)}, {"program", to_json(pushed)}});
}

}  // namespace

void push() {
  for (const std::size_t side : {4, 100}) compare(side);
}

}  // namespace slipd::bench
