// What known weights on a sensor show of its scales, signs, axes and layout. Pure computation; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/frame/layout.hpp"
#include "tools/slipctl/calibration/reading.hpp"

namespace slipctl::calibration {

// What is on the sensor, in the order in which a person is asked for it.
enum class Step : std::uint8_t {
  zero,     // nothing
  normal,   // the weight rests on it
  shear_x,  // the weight pulls along +x
  shear_y,  // the weight pulls along +y
  corner,   // the weight rests on the corner of least x and y
  corner_x  // the weight rests on the corner of greatest x and least y
};

inline constexpr std::array kSteps{Step::zero,    Step::normal, Step::shear_x,
                                   Step::shear_y, Step::corner, Step::corner_x};
std::string_view to_string(Step step) noexcept;  // "zero", "shear-x", …
std::optional<Step> step_of(std::string_view text) noexcept;

using Readings = std::map<Step, Reading>;

// The sensor as it is configured.
struct Pad {
  slipd::SensorClass sensor_class = slipd::SensorClass::array3;
  std::array<double, 2> least_mm{}, greatest_mm{};  // of the taxels' centres, x and y
  bool has_shear() const noexcept { return sensor_class != slipd::SensorClass::normal; }
};

struct Weights {
  double normal_n = 0;  // force of the weight that rests on the sensor, N; above 0
  double shear_n = 0;   // force of the weight that pulls, N; 0: none does
};

// How one axis of slipd's has to be made from what is read.
struct AxisScale {
  std::size_t read_on = 0;  // the axis that its force is read on: kX, kY, kNormal
  double factor = 1;        // of what is read there; below 0: the sign is wrong
  double sigma = 0;         // standard deviation of the factor, by noise alone
  double beside = 0;        // the largest part of the force that was read on another axis, 0 … 0.5
};

// How the positions of taxels have to be changed: first exchanged, then mirrored.
struct LayoutChange {
  std::optional<bool> transposed;  // x and y of the positions are exchanged; none: not known
  bool mirrored_x = false, mirrored_y = false;
  bool any() const noexcept { return transposed.value_or(false) || mirrored_x || mirrored_y; }
};

struct Scales {
  AxisScale normal;
  std::optional<AxisScale> x, y;  // none: no weight pulled
  std::optional<LayoutChange> layout;
  bool axes_in_place() const noexcept;  // each force is read on its own axis
  bool signs_right() const noexcept;
  // The one factor that all measured axes have in magnitude; none: they differ by more than noise and what
  // weights and threads are true to.
  std::optional<AxisScale> common() const noexcept;
};

// what() is for the person with the weight, and says what to do.
class CalibrationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What is wrong with the reading of a step with a load; empty: it can be used. `zero`: that without a load.
std::string trouble_of(Step step, const Reading& zero, const Reading& loaded);

// Needs `zero` and `normal`; shear_x and shear_y together or not at all; `corner` before corner_x. Throws
// CalibrationError where a step is missing, was not still, has too small a weight, or contradicts another.
Scales scales_of(const Pad& pad, const Weights& weights, const Readings& readings);

}  // namespace slipctl::calibration
