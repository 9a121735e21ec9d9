#include "tests/support/gripper/carry.hpp"

#include <algorithm>
#include <random>

#include "tests/support/gripper/closed_loop.hpp"

namespace slipd::gripper {
namespace {

// least factor by which one step reduces friction; with less, the object slips before a gripper can react
constexpr double kLeftByAStep = 0.7;
constexpr double kNothing = 1e-9;  // a smaller margin counts as a slip

sim::Phase phase(double seconds, double friction, sim::Ramp shear_n) {
  sim::Phase made;
  made.shear_n = shear_n;
  made.duration_ns = static_cast<std::int64_t>(seconds * 1e9);
  made.friction = friction;
  return made;
}

}  // namespace

CarryTask draw_carry_task(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  CarryTask task;
  auto& sensor = task.sensor;
  sensor.imperfections.noise = 0.01;
  sensor.imperfections.seed = random();
  sensor.offset_x_m = within(-0.001, 0.001);
  sensor.offset_y_m = within(-0.001, 0.001);
  double friction = within(0.6, 0.9);
  const double margin = within(0.5, 0.65), weight_n = within(0.5, 1.0);
  const double swing_n = within(0.05, 0.2) * weight_n;
  task.gripper.force_n = weight_n / (friction * (1 - margin));
  const auto pass = [&](double time_s, double from_n, double to_n) {
    sensor.cycle.push_back(phase(time_s, friction, {from_n, to_n}));
    task.length_s += time_s;
  };
  pass(0.2, 0, 0);
  pass(within(0.2, 0.5), 0, weight_n - swing_n);
  task.lifted_s = task.length_s;
  const auto swing = [&] {
    const double half_s = within(0.05, 0.15);
    for (int times = 0; times < 3; ++times) {
      pass(half_s, weight_n - swing_n, weight_n + swing_n);
      pass(half_s, weight_n + swing_n, weight_n - swing_n);
    }
  };
  swing();
  for (double held = 1 - margin; held < 1;) {
    const double left = within(kLeftByAStep, 0.9);
    friction *= left;
    held /= left;
    swing();
  }
  return task;
}

CarryResult carry(const CarryTask& task, const ChainSetup& setup, bool listening) {
  ClosedLoop loop(task.sensor, task.gripper, setup, listening);
  const sim::Script script(task.sensor.cycle);
  const double frame_s = std::chrono::duration<double>(ClosedLoop::kFrame).count();
  const auto frames = static_cast<std::int64_t>(task.length_s / frame_s) - 1;
  CarryResult carried;
  double force_n = 0, least_n = 0, most_n = 0;
  std::size_t lifted = 0;
  for (std::int64_t i = 1; i <= frames; ++i) {
    loop.step();
    CarrySample& sample = carried.samples.emplace_back();
    sample.time_s = static_cast<double>(i) * frame_s;
    sample.force_n = loop.force_n();
    sample.truth = loop.truth();
    sample.received = loop.received();
    const std::int64_t now_ns = i * std::chrono::nanoseconds(ClosedLoop::kFrame).count();
    script.walk(now_ns, now_ns,
                [&](const sim::LoadTarget& target) { sample.least_n = target.shear / target.friction; });
    if (sample.time_s < task.lifted_s) continue;
    force_n += sample.force_n;
    least_n += sample.least_n;
    most_n = std::max(most_n, sample.least_n);
    ++lifted;
    if (sample.truth.gamma < kNothing) carried.sliding_s += frame_s;
  }
  carried.force_share = force_n / least_n;
  carried.constant_share = most_n * static_cast<double>(lifted) / least_n;
  return carried;
}

}  // namespace slipd::gripper
