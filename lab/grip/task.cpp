#include "lab/grip/task.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "lab/frames/draws.hpp"

namespace lab::grip {
namespace {

constexpr double kGravity = 9.81;
// Objects that would need more than this of each finger, N, are drawn again.
constexpr double kMostNeededN = 22;

// Smooth from 0 to 1 within `over_s`.
double ramp(double time_s, double over_s) {
  const double t = std::clamp(time_s / over_s, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Up and down within the load's time.
double bump(const Load& load, double time_s) {
  const double t = (time_s - load.at_s) / load.for_s;
  return t <= 0 || t >= 1 ? 0 : std::sin(std::numbers::pi * t);
}

// Up, held, and down.
double plateau(const Load& load, double time_s, double edge_s) {
  return ramp(time_s - load.at_s, edge_s) * (1 - ramp(time_s - load.at_s - load.for_s, edge_s));
}

Load draw_load(Draws& random, double at_s) {
  const auto kind = static_cast<Load::Kind>(random.below(5));
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  switch (kind) {
    case Load::Kind::step:
      return {kind, at_s, 0.6, random.uniform(0.1, 0.5), angle};
    case Load::Kind::tap:
      return {kind, at_s, 0.03, random.uniform(0.3, 0.8), angle};
    case Load::Kind::tilt:
      return {kind, at_s, 0.8, random.uniform(0.1, 0.5), angle};
    case Load::Kind::shake:
      return {kind, at_s, 0.8, random.uniform(0.05, 0.25), random.uniform(2, 6)};
    case Load::Kind::friction_fall:
      return {kind, at_s, 0.1, random.uniform(0.1, 0.3), 0};
  }
  return {};
}

Task draw(std::uint64_t number, std::uint64_t attempt) {
  Draws random(slipd::RandomStream(number * 1000 + attempt));
  Task task;
  task.number = number;
  task.shape = static_cast<Shape>(random.below(3));
  task.half_width_m = random.uniform(0.015, 0.03);
  task.mass_kg = 0.05 * std::pow(16, random.uniform(0, 1));
  task.center_m = {0, random.uniform(-0.004, 0.004), random.uniform(-0.01, 0)};
  task.friction = random.uniform(0.25, 1);
  task.lift_s = random.uniform(0.3, 0.8);
  double at_s = kLiftAt + task.lift_s + 1;
  for (int i = 0; i < 3; ++i) {
    task.loads.push_back(draw_load(random, at_s));
    at_s += random.uniform(1.2, 1.8);
  }
  task.length_s = at_s;
  return task;
}

// Of each finger, N, for the greatest load that steps and taps make.
double needed_n(const Task& task) {
  double share = 1;
  for (const Load& load : task.loads)
    if (load.kind != Load::Kind::tilt && load.kind != Load::Kind::friction_fall)
      share = std::max(share, 1 + load.size);
  return share * task.mass_kg * kGravity / (2 * task.lowest_friction());
}

}  // namespace

std::array<double, 3> Task::load_n(double time_s) const {
  const double weight = mass_kg * kGravity;
  std::array<double, 3> down{0, 0, -1};
  double heavier = 1;
  double y = 0, z = 0;
  for (const Load& load : loads) {
    switch (load.kind) {
      case Load::Kind::step:
      case Load::Kind::tap: {
        const double now =
            load.size * (load.kind == Load::Kind::tap ? bump(load, time_s) : plateau(load, time_s, 0.05));
        y += now * std::sin(load.angle);
        z -= now * std::cos(load.angle);
        break;
      }
      case Load::Kind::tilt: {
        const double tilted = load.size * plateau(load, time_s, 0.2);
        down = {std::sin(tilted) * std::sin(load.angle), std::sin(tilted) * std::cos(load.angle),
                -std::cos(tilted)};
        break;
      }
      case Load::Kind::shake:
        heavier += load.size * plateau(load, time_s, 0.1) *
                   std::sin(2 * std::numbers::pi * load.angle * (time_s - load.at_s));
        break;
      case Load::Kind::friction_fall:
        break;
    }
  }
  const double lifted = weight * ramp(time_s - kLiftAt, lift_s);
  return {lifted * heavier * down[0], lifted * (heavier * down[1] + y), lifted * (heavier * down[2] + z)};
}

double Task::friction_at(double time_s) const {
  double now = friction;
  for (const Load& load : loads)
    if (load.kind == Load::Kind::friction_fall) now *= 1 - load.size * ramp(time_s - load.at_s, load.for_s);
  return now;
}

double Task::lowest_friction() const {
  return friction_at(length_s);
}

Task draw_task(std::uint64_t number) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    Task task = draw(number, attempt);
    if (needed_n(task) < kMostNeededN) return task;
  }
}

std::string describe(const Task& task) {
  static constexpr const char* kShapes[] = {"box", "cylinder", "sphere"};
  static constexpr const char* kLoads[] = {"step", "tap", "tilt", "shake", "friction"};
  char text[160];
  std::snprintf(text, sizeof text,
                "%3llu %-8s %4.0f g, friction %.2f -> %.2f:", static_cast<unsigned long long>(task.number),
                kShapes[static_cast<int>(task.shape)], task.mass_kg * 1000, task.friction,
                task.lowest_friction());
  std::string all = text;
  for (const Load& load : task.loads) all += std::string(" ") + kLoads[static_cast<int>(load.kind)];
  return all;
}

}  // namespace lab::grip
