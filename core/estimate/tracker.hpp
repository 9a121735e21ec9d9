// Friction over time. A frame whose load has only risen tells its margin by itself; after a regrip, an
// unloading or a reversal it does so only together with the friction and the forces of the frames before, and
// the margin is 1 - |Q|/(mu P).
#pragma once

#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "core/estimate/friction_filter.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/settings.hpp"

namespace slipd {

class Tracker {
 public:
  // friction_expected: the scene's range. friction: known beforehand. few_taxels: no single frame of this
  // sensor tells its margin.
  Tracker(const EstimatorSettings& settings, Range friction_expected, std::optional<double> friction,
          bool few_taxels);

  // Estimate thread. Fills in state, gamma, sigma, friction and method of `out`, whose forces and sequence
  // are set. `reading` is null where the sensor has no method of its own (one force vector, flat skin), or
  // the frame no shear.
  void update(const ContactPatch& patch, const FrameEstimate* frame_estimate, Method method,
              Estimate& out) noexcept;

  // The contact was lost: what was learnt of this object is forgotten.
  void forget() noexcept { friction_filter_.reset(); }

 private:
  using Margin = FrictionGrid::Value;
  std::optional<Margin> track(const ContactPatch& patch, const FrameEstimate* frame_estimate, Method method,
                              Estimate& out) noexcept;

  EstimatorSettings settings_;
  bool few_taxels_;
  FrictionFilter friction_filter_;
};

}  // namespace slipd
