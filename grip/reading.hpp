// What of slipd's estimate decides how hard to grip.
#pragma once

#include <slipd.h>

#include <optional>

namespace slipd::grip {

// Unknown numbers are NaN.
struct Reading {
  // Whether gamma may be used: state ok, young enough, and watched.
  bool known = false;
  // Whether gamma_low may be: state ok or learning, young enough, and watched.
  bool bounded = false;
  // Whether the sensors tell of something between the fingers; nullopt: they do not tell.
  std::optional<bool> contact;
  // A slide, or an alert of slip that is of this frame: not one from before slipd or the sensor went, nor,
  // without a margin, one of a slide that has ended.
  bool slips = false;
  double gamma = 0, gamma_low = 0, sigma = 0;
  double normal_n = 0;        // of all fingers
  double shear_n = 0;         // of all fingers
  double increase_n = 0;      // advice, of all fingers
  double time_to_slip_s = 0;  // forecast
};

// Whether the object is seen to slide.
bool slides(const slipd_estimate& now) noexcept;

// finger_slides: a finger of the grasp that the estimate is of.
Reading reading_of(const slipd_estimate& now, bool finger_slides) noexcept;

}  // namespace slipd::grip
