// What the taxels' pattern shows beside the margin: whether the object slides, and how far it has turned.
// Estimate thread; allocates in constructors only.
#pragma once

#include "core/estimate/estimate.hpp"
#include "core/frame/frame.hpp"
#include "core/patch/patch.hpp"
#include "core/sliding/sliding.hpp"
#include "core/sliding/turned_angle.hpp"

namespace slipd {

// Of a sensor without a pattern: one force.
class PatternObserver {
 public:
  virtual ~PatternObserver() = default;
  // Its name among the stages; empty: it is none.
  virtual std::string_view name() const noexcept { return {}; }
  // Sliding, a frame ago.
  virtual const SlidingVerdict& previous() const noexcept { return none_; }
  // One frame. `contact`: ignored for frames without a zero.
  virtual void observe(const Frame& /*frame*/, bool /*contact*/, Estimate& /*out*/) noexcept {}
  // After observe(), for a frame in contact. slides_turning: force and torque are at the limit of friction.
  virtual void follow_turn(const ContactPatch& /*patch*/, bool /*slides_turning*/,
                           Estimate& /*out*/) noexcept {}
  // The contact was lost.
  virtual void forget() noexcept {}

 private:
  SlidingVerdict none_;
};

class TaxelPatternObserver final : public PatternObserver {
 public:
  TaxelPatternObserver(const TaxelLayout& layout, double false_alarms_per_hour)
      : sliding_(layout, false_alarms_per_hour), turn_(layout) {}

  std::string_view name() const noexcept override { return "taxel_pattern"; }
  const SlidingVerdict& previous() const noexcept override { return verdict_; }

  void observe(const Frame& frame, bool contact, Estimate& out) noexcept override {
    verdict_ = sliding_.update(frame, contact);
    out.sliding = verdict_.sliding;
    if (verdict_.sliding) out.sliding_for_s = verdict_.for_s;
    out.pattern = verdict_.course;
  }

  void follow_turn(const ContactPatch& patch, bool slides_turning, Estimate& out) noexcept override {
    const auto turned = turn_.update(out.time_ns, patch, verdict_.field.settled, slides_turning);
    if (!turned) return;
    out.turned_rad = turned->angle_rad;
    out.turned_sigma_rad = turned->sigma_rad;
  }

  void forget() noexcept override { turn_.forget(); }

 private:
  SlidingDetector sliding_;
  SlidingVerdict verdict_;
  TurnFollower turn_;
};

}  // namespace slipd
