// Friction where single frames say little of their own: one force, flat pads, few taxels. Gross slip is read
// from |Q|/P, which stays even while P falls. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include "core/friction/friction_filter.hpp"

namespace slipd {

class FrictionByForces final : public FrictionFilter {
 public:
  explicit FrictionByForces(const FrictionPrior& prior, const FrictionFilterOptions& options = {});

  void update(const FrictionFrame& frame) noexcept override;
  void reset() noexcept override;

 private:
  void forget_lighter(const ContactPatch& patch) noexcept;
  void watch_hook() noexcept;
  void weigh_frame(const ContactPatch& patch, const Reading& reading) noexcept;
  void weigh_slide(const TractionRatioFilter::Slide& slide) noexcept;

  // What a new grasp forgets.
  struct GraspState {
    double lighter_n = 0;  // P that the evidence stands for; 0: none yet
    bool exceeds_friction =
        false;  // the load exceeded any friction, and has not fallen below all of them since
  };

  GraspState grasp_;
};

}  // namespace slipd
