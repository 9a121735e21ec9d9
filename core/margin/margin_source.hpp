// Where a frame's margin comes from: from this frame alone, or from friction over time. One of them is chosen
// when a pipeline is made.
#pragma once

#include <string_view>

#include "core/estimate/estimate.hpp"
#include "core/load/load_path.hpp"
#include "core/margin/margin_decision.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

// One frame in contact, as a source of margins takes it.
struct MarginInput {
  // As it was measured.
  const ContactPatch& measured;
  // From the frame before to this one.
  const LoadStep& step;
  // With the forces that act, and in shear_n the equivalent pull.
  const ContactPatch& acting;
  // What the frame shows by itself; null where the sensor has no method, or the frame no shear.
  const Reading* reading = nullptr;
  // What a pad shows of its margin (core/friction/pad_load_sharing.hpp); null: nothing.
  const MarginProfile* shared = nullptr;
  // The object's sliding, a frame ago.
  const SlidingVerdict& previous_sliding;
};

class MarginSource {
 public:
  virtual ~MarginSource() = default;
  // Its name among the stages of a pipeline.
  virtual std::string_view name() const noexcept = 0;
  // Proposes a margin, or says why there is none. Writes friction, what it can carry, the method, and to
  // health that frames contradict every friction. Estimate thread; allocates nothing.
  virtual void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept = 0;
  // As learnt in this grasp so far, or as given or expected; > 0.
  virtual double friction() const noexcept = 0;
  // The contact was lost.
  virtual void forget() noexcept = 0;
  // The contact goes on, or another one has come, and what it does is not seen.
  virtual void lose_sight() noexcept { forget(); }
};

// Each frame for itself: settings without tracking.
class SingleFrameMargin final : public MarginSource {
 public:
  explicit SingleFrameMargin(double friction) noexcept : friction_(friction) {}
  std::string_view name() const noexcept override { return "single_frame_margin"; }
  void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept override;
  double friction() const noexcept override { return friction_; }
  void forget() noexcept override {}

 private:
  const double friction_;
};

}  // namespace slipd
