// Accuracy under a skin and on elliptic contacts, against the Cramér–Rao guide.
#pragma once

#include <string>
#include <vector>

#include "core/contact/scene.hpp"
#include "lab/tradeoff/measure.hpp"

namespace lab {

// One layout, skin and shape; the noise is that of the sensor, 1 %.
struct ShapeLine {
  std::string layout;   // as in TradeoffOptions
  std::string method;   // fit, or closing: after frames of the gripper's closing
  double depth_mm = 0;  // of the taxels
  double axes = 1;      // long over short axis
  double power = 2;     // n of a profile r^n; 2: Hertz's contact
  // The depth that the method is set to, over the true one.
  double depth_taken = 1;
  // What the skin lies on, and what the method takes it to lie on.
  slipd::SkinBase base = slipd::SkinBase::half_space, base_taken = slipd::SkinBase::half_space;
  // Mean |error| of Gamma by the Cramér–Rao bound with the prior 0 … 1, for closing that of known maps; NaN
  // where the depth or the base is wrong.
  double guide = 0;
  slipd::TradeoffRow row;
  std::size_t unit = 0;  // its number in the sweep
};

// On the layouts of the options that are arrays.
std::vector<ShapeLine> measure_shapes(const TradeoffOptions& options, const Tell& tell);

void print_shapes(const std::vector<ShapeLine>& lines, std::size_t contacts);
offline::SweepResult shapes_to_sweep(const std::vector<ShapeLine>& lines, std::size_t contacts);

}  // namespace lab
