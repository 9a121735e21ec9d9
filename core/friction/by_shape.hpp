// Friction where frames have a shape. Each friction of the grid follows the grasp's forces with a Winkler
// foundation of its own. A frame takes weight from those whose contact would look otherwise by now, after a
// regrip, an unloading or a reversal just as after a monotonic load (docs/methods.md §28). Estimate thread;
// fixed memory, nothing allocates.
#pragma once

#include "core/friction/followed_forces.hpp"
#include "core/friction/foundations/winkler_foundations.hpp"
#include "core/friction/friction_filter.hpp"

namespace slipd {

class FrictionByShape final : public FrictionFilter {
 public:
  explicit FrictionByShape(const FrictionPrior& prior, const FrictionFilterOptions& options = {});

  // The foundations know pulls only: where a torque has changed the field they rest, and start anew
  // afterwards.
  void update(const FrictionFrame& frame) noexcept override;
  void reset() noexcept override;
  // The history is assumed until frames confirm it.
  void lose_sight() noexcept override;

  MeanSigma margin_offset() const noexcept override { return grasp_.margin_offset; }
  bool explained() const noexcept override {
    return !grasp_.shear_lost && grasp_.unverified_frames <= options_.history.confirming_frames;
  }
  bool shear_lost() const noexcept override { return grasp_.shear_lost; }
  bool understood() const noexcept override {
    return (frame_.turning || is_known(history())) && explained_of_late();
  }

 protected:
  void lose_history(HistoryEvent why) noexcept override;

 private:
  // What a new grasp forgets.
  struct GraspState {
    MeanSigma margin_offset;  // see margin_offset()
    // The most, since the load was last monotonic, of what taxels make of shear moments, N.
    contact::ShearMoments locked_in_sigma;
    bool other_history = false;  // the load was not monotonic once
    bool shear_lost = false;     // shear fell to noise in one step
    int unverified_frames = 0;   // frames in a row with a clear shear that said nothing of friction
  };

  // was_turning: the frame before was under a torque.
  void follow(const ContactPatch& patch, bool was_turning) noexcept;
  bool looks_monotonic(double normal_n, double load) noexcept;
  // True if the frame said something of friction.
  bool weigh_torque(const Reading& reading) noexcept;
  bool weigh_frame(const FrictionFrame& frame) noexcept;
  bool compare_margin(const ContactPatch& patch, const Reading& reading) noexcept;
  bool compare_moments(const ContactPatch& patch, const Reading& reading, bool followed_only) noexcept;
  // What the contact of a friction differs from one after a monotonic load.
  struct HistoryOffset {
    double beyond_n = 0;    // of the slip moment, along the shear
    double margin = 0;      // of the margin read, by what of that is clear
    double unresolved = 0;  // of the margin: what is not clear
  };
  HistoryOffset offset_of(std::size_t friction, double load, double normal_n) const noexcept;
  void verify(const FrictionFrame& frame, bool clear) noexcept;

  FollowedForces forces_;
  WinklerFoundations foundations_;
  GraspState grasp_;
  struct ThisFrame {
    bool turning = false;  // its shear was changed by a torque
  };
  ThisFrame frame_;
};

}  // namespace slipd
