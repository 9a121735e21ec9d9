// What each way to the safety margin has in common: one frame and its contact patch in, one reading out, each
// frame for itself. What happens over time is the tracker's.
#pragma once

#include "core/estimate/estimate.hpp"
#include "core/estimate/rings.hpp"

namespace slipd {

// One frame's word. `in_family` false: the frame is no contact whose load has only risen (or whatever else
// the method covers), and the numbers mean nothing. Sigmas are standard deviations; friction_sigma is
// infinite where the frame does not tell friction (no load).
struct Reading {
  bool in_family = false;
  RimReading rim;
  double gamma = 0, sigma = 0;
  double friction = 0, friction_sigma = 0;
  double center_x_m = 0, center_y_m = 0, radius_m = 0;
};

class SlipMethod {
 public:
  virtual ~SlipMethod() = default;
  virtual Method name() const noexcept = 0;
  // Estimate thread. Allocates nothing. `patch` is of this very frame and touched, with shear above the
  // noise.
  virtual Reading read(const Frame& frame, const ContactPatch& patch) noexcept = 0;
};

}  // namespace slipd
