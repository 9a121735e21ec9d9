// What each way to the safety margin has in common: one frame and its contact patch in, one reading out, each
// frame for itself. What happens over time is the tracker's.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "core/contact/shear_moments.hpp"
#include "core/estimate/estimate.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// Sigma of Gamma, of 1 - Gamma, below which a frame gives friction; 0.1 … 1. Near no load friction is a ratio
// of two small numbers. Too small: friction is given late. Too large: its sigma is not meant, because the
// likelihood is no parabola.
inline constexpr double kKnownFrictionShare = 0.5;

// Sigma of Gamma beyond which a frame gives its whole profile; 0.005 … 0.3. Too small: costs time, and frames
// whose error is common count too much. Too large: the likelihood is no parabola any more.
inline constexpr double kOpenSigma = 0.04;

// Sigma of Gamma over the part of the pressure or the shear that is clearly not explained, of the peak or of
// its root sum of squares; 0.1 … 5. Too small: sigma is less than the error on contacts that are not as the
// method has them. Too large: it is more.
inline constexpr double kUnexplainedSigma = 0.9;

// How little each margin fits a frame: half the squared misfit in units of noise, Gamma = (j + 1/2)/kSteps,
// the least is 0. The scene's expectations are not in it.
struct MarginProfile {
  static constexpr std::size_t kSteps = 24;
  bool known = false;
  std::array<double, kSteps> misfit{};

  // The middle of step j.
  static constexpr double gamma_of(std::size_t j) noexcept { return (static_cast<double>(j) + 0.5) / kSteps; }

  double at(double gamma) const noexcept {  // linear in between, constant beyond the ends
    const double place = std::clamp(gamma * kSteps - 0.5, 0.0, kSteps - 1.0);
    const auto low = std::min(static_cast<std::size_t>(place), kSteps - 2);
    const double part = place - static_cast<double>(low);
    return (1 - part) * misfit[low] + part * misfit[low + 1];
  }
};

// One frame's word. `in_model` false: the frame is no contact whose load has only risen (or whatever else
// the method covers), and the numbers mean nothing. Sigmas are standard deviations; friction_sigma is
// infinite where the frame does not determine friction (no load).
struct Reading {
  // The method that read the frame.
  Method by = Method::none;
  bool in_model = false;
  // The contact carries a torque that makes its shear no sum of disc terms: gamma and friction are of that
  // load, by taxels that slip; there are no moments and no profile.
  bool under_torque = false;
  // Of `under_torque`, not in_model: the load has fallen since, and what slipped sticks again. `friction` is
  // a ratio that friction is not below, 0 where none is seen.
  bool load_fallen = false;
  // How the shear lies along the resultant, whatever the contact went through: see ShearMoments.
  // Deviations are infinite where it is not known.
  contact::ShearMoments moments,
      moments_sigma{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  double gamma = 0, sigma = 0;
  // The part of `sigma` that frames of one contact have in common, which no mean over them takes away: the
  // method's own error and that of its model, Gamma, 0 … sigma. The rest is noise, new in each frame.
  double common_sigma = 0;
  // The part of `common_sigma` by how far the pressure is from the method's contact model, Gamma, also where
  // in_model is false. Under a skin only; 0 where the method does not compare them, or could not.
  double shape_sigma = 0;
  // `common_sigma` of `moments_sigma`, N.
  contact::ShearMoments moments_common_sigma;
  double friction = 0, friction_sigma = 0;
  double center_x_m = 0, center_y_m = 0, radius_m = 0;
  // Forces of the contact by the model, N, where the disc reads only a part of them: under a skin. 0: those
  // of the patch.
  double normal_n = 0, shear_n = 0;
  // Standard deviations of one taxel's pressure and shear by what a fit leaves over, Pa: of few taxels under
  // a skin. 0: not known.
  double noise_normal_pa = 0, noise_shear_pa = 0;
  MarginProfile profile;  // of methods that weigh every margin, where the frame leaves it open

  // Another method's shear moments of the same frame, and the forces that they are of.
  void take_moments(const Reading& from) noexcept {
    moments = from.moments;
    moments_sigma = from.moments_sigma;
    moments_common_sigma = from.moments_common_sigma;
    if (!(from.shear_n > 0)) return;
    normal_n = from.normal_n;
    shear_n = from.shear_n;
  }
};

class SlipMethod {
 public:
  virtual ~SlipMethod() = default;
  virtual Method name() const noexcept = 0;
  virtual MethodSettings settings() const noexcept = 0;  // any thread
  // Estimate thread. Allocates nothing. `patch` is of this very frame and touched, with shear above the
  // noise.
  virtual Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept = 0;
  // For methods that record the contact: called for each frame of it, before estimate() and also where shear
  // is noise; and when the contact is lost. Estimate thread. Allocates nothing.
  virtual void observe(const Frame& /*frame*/, const ContactPatch& /*patch*/) noexcept {}
  virtual void forget() noexcept {}
};

}  // namespace slipd
