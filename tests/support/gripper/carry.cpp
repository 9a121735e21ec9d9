#include "tests/support/gripper/carry.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/contact/limit_surface.hpp"
#include "tests/support/gripper/closed_loop.hpp"

namespace slipd::gripper {
namespace {

// least factor by which one step reduces friction; with less, the object slips before a gripper can react
constexpr double kLeftByAStep = 0.7;
constexpr double kNothing = 1e-9;  // a smaller margin counts as a slip
// weight of an object on a lever, of that of one without: its torque must not need more than the pad bears
constexpr double kLeverWeightShare = 0.3;

// The least normal force that holds a pull on its lever.
class LeastGrip {
 public:
  explicit LeastGrip(const sim::SensorSettings& sensor)
      : lever_m_(sensor.lever_m),
        pair_(contact::make_body_pair(sensor.skin, sensor.object)),
        hertz_(contact::unit_hertz_surface()) {}

  // N; of a pull in N, with this friction.
  double normal_n(double pull_n, double friction) const {
    const double alone_n = pull_n / friction;
    if (lever_m_ == 0 || !(pull_n > 0)) return alone_n;
    constexpr int kHalvings = 40;
    double low_n = alone_n, high_n = alone_n;
    while (!holds(high_n, pull_n, friction)) high_n *= 2;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle_n = (low_n + high_n) / 2;
      (holds(middle_n, pull_n, friction) ? high_n : low_n) = middle_n;
    }
    return high_n;
  }

 private:
  bool holds(double normal_n, double pull_n, double friction) const {
    const double lever = lever_m_ / pair_.contact_radius_m(normal_n);
    return pull_n * hertz_.least_friction(1, 0, lever).ratio <= friction * normal_n;
  }

  double lever_m_;
  contact::BodyPair pair_;
  contact::LimitSurface hertz_;
};

sim::Phase phase(double seconds, double friction, sim::Ramp shear_n) {
  sim::Phase made;
  made.shear_n = shear_n;
  made.duration_ns = static_cast<std::int64_t>(seconds * 1e9);
  made.friction = friction;
  return made;
}

}  // namespace

CarryTask draw_carry_task(std::uint64_t seed, double lever_m) {
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
  sensor.lever_m = lever_m;
  const double margin = within(0.5, 0.65), drawn_n = within(0.5, 1.0);
  const double weight_n = lever_m == 0 ? drawn_n : kLeverWeightShare * drawn_n;
  const double swing_n = within(0.05, 0.2) * weight_n;
  task.gripper.force_n = LeastGrip(sensor).normal_n(weight_n, friction * (1 - margin));
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
  const LeastGrip least(task.sensor);
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
                [&](const sim::LoadTarget& target) {
                  sample.least_n = least.normal_n(target.shear, target.friction);
                });
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
