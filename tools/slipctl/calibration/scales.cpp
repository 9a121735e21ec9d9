#include "tools/slipctl/calibration/scales.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace slipctl::calibration {
namespace {

using Vector = std::array<double, 3>;

// A scale is wanted to so much of itself, one standard deviation; 0.01 … 0.1. Too small: needs heavy weights.
// Too large: the scale is no better than a guess.
constexpr double kWorstSigma = 0.03;
// Part of the load by which a still sensor may creep; 0.01 … 0.1. Too small: soft skins are never still. Too
// large: a swinging weight passes.
constexpr double kMostMotion = 0.05;
// Part of a force on another axis from which it is not known which axis it is on.
constexpr double kMostBeside = 0.5;
// Part by which factors of axes differ because of weights and threads; 0.01 … 0.05.
constexpr double kAlike = 0.03;
// Of the pad's half, from its middle, from which a weight is at a corner.
constexpr double kAtCorner = 0.2;

const char* const kAxisNames[] = {"x", "y", "normal"};

std::string named(Step step) {
  return "step " + std::string(to_string(step));
}

Vector change_of(const Reading& zero, const Reading& loaded) {
  Vector out{};
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = loaded.force_n[axis] - zero.force_n[axis];
  return out;
}

std::size_t largest(const Vector& change, const std::vector<std::size_t>& axes) {
  return *std::max_element(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) {
    return std::fabs(change[a]) < std::fabs(change[b]);
  });
}

const Reading& reading_at(const Readings& readings, Step step) {
  const auto found = readings.find(step);
  if (found == readings.end()) throw CalibrationError(named(step) + " is missing");
  return found->second;
}

// What is wrong with a load that is read on this axis; empty: nothing.
std::string trouble_on(std::size_t axis, Step step, const Reading& zero, const Reading& loaded) {
  const double read_n = std::fabs(change_of(zero, loaded)[axis]);
  const auto moves = [&](const Reading& reading) {
    return reading.range_n[axis] > std::max(reading.chance_n[axis], kMostMotion * read_n);
  };
  if (moves(zero))
    return named(Step::zero) + " was not still: its values moved, let the sensor rest and repeat it";
  if (moves(loaded)) return named(step) + " was not still: let the weight come to rest, and repeat it";
  const double sigma_n = std::hypot(zero.sigma_n[axis], loaded.sigma_n[axis]);
  if (sigma_n <= kWorstSigma * read_n && read_n > 0) return {};
  char text[160];
  std::snprintf(text, sizeof text,
                ": the weight changes what is read by %.3g +- %.2g (N as scaled now), too little beside the "
                "noise: take a heavier weight or more --seconds",
                read_n, sigma_n);
  return named(step) + text;
}

// The axis among `axes` that the load of a step is read on.
AxisScale axis_scale(Step step, double load_n, const Reading& zero, const Reading& loaded,
                     const std::vector<std::size_t>& axes) {
  const Vector change = change_of(zero, loaded);
  AxisScale out{.read_on = largest(change, axes)};
  const double read_n = change[out.read_on];
  if (const std::string trouble = trouble_on(out.read_on, step, zero, loaded); !trouble.empty())
    throw CalibrationError(trouble);
  for (const std::size_t other : axes) {
    if (other != out.read_on) out.beside = std::max(out.beside, std::fabs(change[other] / read_n));
  }
  if (out.beside > kMostBeside) {
    throw CalibrationError(named(step) + ": the force is read on two axes at once, " +
                           kAxisNames[out.read_on] +
                           " and another: let the weight act along one axis of the sensor");
  }
  out.factor = load_n / read_n;
  out.sigma =
      std::fabs(out.factor / read_n) * std::hypot(zero.sigma_n[out.read_on], loaded.sigma_n[out.read_on]);
  return out;
}

void pulls(Scales& out, const Weights& weights, const Readings& readings) {
  std::vector<std::size_t> tangential{kX, kY, kNormal};
  std::erase(tangential, out.normal.read_on);
  const Reading& zero = reading_at(readings, Step::zero);
  out.x = axis_scale(Step::shear_x, weights.shear_n, zero, reading_at(readings, Step::shear_x), tangential);
  out.y = axis_scale(Step::shear_y, weights.shear_n, zero, reading_at(readings, Step::shear_y), tangential);
  if (out.x->read_on == out.y->read_on) {
    throw CalibrationError("pulls along x and along y are both read on " +
                           std::string(kAxisNames[out.x->read_on]) +
                           ": look at the sensor's drawing for its x and y, and repeat step shear-y");
  }
}

// Where the load is, x and y: -1 … 1 from one end of the pad to the other.
std::array<double, 2> place_of(const Pad& pad, Step step, std::size_t normal_axis, const Reading& zero,
                               const Reading& loaded) {
  std::array<double, 2> out{};
  const double force_n = loaded.force_n[normal_axis] - zero.force_n[normal_axis];
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double at_mm = (loaded.moment_nmm[axis] - zero.moment_nmm[axis]) / force_n;
    const double middle_mm = 0.5 * (pad.least_mm[axis] + pad.greatest_mm[axis]);
    const double half_mm = 0.5 * (pad.greatest_mm[axis] - pad.least_mm[axis]);
    out[axis] = half_mm > 0 ? (at_mm - middle_mm) / half_mm : 0;
    if (std::fabs(out[axis]) < kAtCorner) {
      throw CalibrationError(named(step) +
                             ": the weight is read in the middle of the pad: put it on the "
                             "very corner, and use one that is smaller than a quarter of the pad");
    }
  }
  return out;
}

LayoutChange layout_change(const Pad& pad, const Scales& scales, const Readings& readings) {
  if (pad.sensor_class == slipd::SensorClass::wrench || scales.normal.read_on != kNormal)
    throw CalibrationError("step corner needs taxels that read pressure on the axis normal");
  const Reading& zero = reading_at(readings, Step::zero);
  const auto first = place_of(pad, Step::corner, kNormal, zero, reading_at(readings, Step::corner));
  LayoutChange out{.transposed = std::nullopt, .mirrored_x = first[kX] > 0, .mirrored_y = first[kY] > 0};
  if (!readings.contains(Step::corner_x)) return out;
  const auto second = place_of(pad, Step::corner_x, kNormal, zero, readings.at(Step::corner_x));
  const bool along_x = first[kX] * second[kX] < 0, along_y = first[kY] * second[kY] < 0;
  if (along_x == along_y) {
    throw CalibrationError(
        "the two corners contradict each other: the first has the least x and y, the second the greatest x "
        "and the least y");
  }
  out.transposed = along_y;
  if (along_y) std::swap(out.mirrored_x, out.mirrored_y);
  return out;
}

}  // namespace

std::string_view to_string(Step step) noexcept {
  static constexpr std::string_view kNames[] = {"zero", "normal", "shear-x", "shear-y", "corner", "corner-x"};
  return kNames[static_cast<std::size_t>(step)];
}

std::optional<Step> step_of(std::string_view text) noexcept {
  for (const Step step : kSteps) {
    if (to_string(step) == text) return step;
  }
  return std::nullopt;
}

bool Scales::axes_in_place() const noexcept {
  return normal.read_on == kNormal && (!x || x->read_on == kX) && (!y || y->read_on == kY);
}

bool Scales::signs_right() const noexcept {
  return normal.factor > 0 && (!x || x->factor > 0) && (!y || y->factor > 0);
}

std::optional<AxisScale> Scales::common() const noexcept {
  std::vector<AxisScale> all{normal};
  for (const auto& each : {x, y}) {
    if (each) all.push_back(*each);
  }
  double factor = 0, variance = 0;
  const auto count = static_cast<double>(all.size());
  for (const AxisScale& each : all) {
    factor += std::fabs(each.factor) / count;
    variance += each.sigma * each.sigma / (count * count);
  }
  for (const AxisScale& each : all) {
    if (std::fabs(std::fabs(each.factor) - factor) > kAlike * factor + 3 * each.sigma) return std::nullopt;
  }
  return AxisScale{.read_on = kNormal, .factor = factor, .sigma = std::sqrt(variance)};
}

std::string trouble_of(Step step, const Reading& zero, const Reading& loaded) {
  return trouble_on(largest(change_of(zero, loaded), {kX, kY, kNormal}), step, zero, loaded);
}

Scales scales_of(const Pad& pad, const Weights& weights, const Readings& readings) {
  const Reading& zero = reading_at(readings, Step::zero);
  reading_at(readings, Step::normal);
  for (const auto& [step, reading] : readings) {
    if (step == Step::zero) continue;
    if (const std::string trouble = trouble_of(step, zero, reading); !trouble.empty())
      throw CalibrationError(trouble);
  }
  const std::vector<std::size_t> axes =
      pad.has_shear() ? std::vector<std::size_t>{kX, kY, kNormal} : std::vector<std::size_t>{kNormal};
  Scales out{.normal = axis_scale(Step::normal, weights.normal_n, zero, readings.at(Step::normal), axes),
             .x = {},
             .y = {},
             .layout = {}};
  if (readings.contains(Step::shear_x) || readings.contains(Step::shear_y)) {
    if (!pad.has_shear()) throw CalibrationError("this sensor measures no shear: leave the pulls out");
    if (weights.shear_n <= 0) throw CalibrationError("the weight that pulls is not known: give --shear");
    pulls(out, weights, readings);
  }
  if (readings.contains(Step::corner) || readings.contains(Step::corner_x))
    out.layout = layout_change(pad, out, readings);
  return out;
}

}  // namespace slipctl::calibration
