#include "tests/support/gripper/carry.hpp"

#include <algorithm>
#include <random>

#include "tests/support/gripper/cell.hpp"

namespace slipd::gripper {
namespace {

constexpr double kLeftByAStep = 0.7;  // of friction, at least; less would slip before any hand can close
constexpr double kNothing = 1e-9;     // a margin below it is a slip

sim::Phase phase(double seconds, double friction, sim::Ramp shear_n) {
  sim::Phase made;
  made.shear_n = shear_n;
  made.duration_ns = static_cast<std::int64_t>(seconds * 1e9);
  made.friction = friction;
  return made;
}

}  // namespace

Errand draw_errand(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Errand errand;
  auto& sensor = errand.sensor;
  sensor.imperfections.noise = 0.01;
  sensor.imperfections.seed = random();
  sensor.offset_x_m = within(-0.001, 0.001);
  sensor.offset_y_m = within(-0.001, 0.001);
  double friction = within(0.6, 0.9);
  const double margin = within(0.5, 0.65), weight_n = within(0.5, 1.0);
  const double swing_n = within(0.05, 0.2) * weight_n;
  errand.gripper.force_n = weight_n / (friction * (1 - margin));
  const auto pass = [&](double time_s, double from_n, double to_n) {
    sensor.cycle.push_back(phase(time_s, friction, {from_n, to_n}));
    errand.length_s += time_s;
  };
  pass(0.2, 0, 0);
  pass(within(0.2, 0.5), 0, weight_n - swing_n);
  errand.lifted_s = errand.length_s;
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
  return errand;
}

Carried carry(const Errand& errand, const ChainSetup& setup, bool listening) {
  Cell cell(errand.sensor, errand.gripper, setup, listening);
  const sim::Script script(errand.sensor.cycle);
  const double frame_s = std::chrono::duration<double>(Cell::kFrame).count();
  const auto frames = static_cast<std::int64_t>(errand.length_s / frame_s) - 1;
  Carried carried;
  double force_n = 0, least_n = 0, most_n = 0;
  std::size_t lifted = 0;
  for (std::int64_t i = 1; i <= frames; ++i) {
    cell.step();
    Moment& moment = carried.moments.emplace_back();
    moment.time_s = static_cast<double>(i) * frame_s;
    moment.force_n = cell.force_n();
    moment.truth = cell.truth();
    moment.heard = cell.heard();
    const std::int64_t now_ns = i * std::chrono::nanoseconds(Cell::kFrame).count();
    script.walk(now_ns, now_ns,
                [&](const sim::LoadTarget& target) { moment.least_n = target.shear / target.friction; });
    if (moment.time_s < errand.lifted_s) continue;
    force_n += moment.force_n;
    least_n += moment.least_n;
    most_n = std::max(most_n, moment.least_n);
    ++lifted;
    if (moment.truth.gamma < kNothing) carried.sliding_s += frame_s;
  }
  carried.force_share = force_n / least_n;
  carried.constant_share = most_n * static_cast<double>(lifted) / least_n;
  return carried;
}

}  // namespace slipd::gripper
