// Margins by friction over time. After a monotonic load a frame determines its margin by itself; after a
// regrip, an unloading or a reversal only together with the friction and the forces of the frames before it,
// and the margin is 1 - |Q|/(mu P) (docs/methods.md §28). One class for each combination of what frames show
// and of what is known of friction.
#pragma once

#include <memory>
#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/settings.hpp"
#include "core/frame/layout.hpp"
#include "core/frame/model_errors.hpp"
#include "core/friction/friction_filter.hpp"
#include "core/load/unobserved_load_change.hpp"
#include "core/margin/margin_source.hpp"

namespace slipd {

// Checked with `slipd-lab histories --grasps 400`.
struct MarginOverTimeOptions {
  FrictionPriorOptions prior;
  FrictionFilterOptions filter;

  // Friction is learnt when frames have left less than this of the prior's relative sigma; 0.1 … 0.95. Too
  // small: friction is given late. Too large: the prior is given for friction.
  double learnt_share = 0.6;
  // Forces alone leave the margin anywhere between what both ends of friction's range make of them. Of a
  // range up to this wide, log of its ends' ratio, 0 … 3, less than a sigma is taken off its mean where
  // sigma_max demands it. Too small: a known range is of no use. Too large: margins of objects of any kind
  // are given from next to nothing.
  double narrow_range = 1.5;
  // Standard deviation of a margin by memory under a torque whose load has fallen, of the range between it
  // and what friction would leave that is just as high as the ratios that taxels carry; 0 … 0.3. Too small:
  // friction that falls between two peaks of the load leaves margins that are given as sure. Too large:
  // cycles lose their margin at each trough.
  double unseen_fall_share = 0.15;
  // Floor of the sigma of friction over a grasp, relative, in a margin that is computed from it: the contact
  // that is followed has errors that all frames share. A frame's own sharper margin is not concerned. More of
  // sensors whose frames have more in common. `slipd-lab coverage --grasps 40 --of histories`.
  double least_friction_sigma = kModelSigma;
};

// What is known of friction before a grasp.
struct FrictionKnowledge {
  // The scene's range, mu.
  Range expected;
  // Given for this sensor, instead of it and as a hard bound; none: nothing was.
  std::optional<KnownFriction> given;
  const Range& range() const noexcept { return given ? given->range : expected; }
};

class MarginOverTime : public MarginSource {
 public:
  double friction() const noexcept override { return last_friction_; }
  void forget() noexcept override {
    filter_->reset();
    last_friction_ = prior_.mean;
  }
  void lose_sight() noexcept override {
    forget();
    filter_->lose_sight();
  }

 protected:
  // bounds: what friction is learnt within, mu. filter: of the sensor's kind.
  MarginOverTime(double sigma_max, Range bounds, std::unique_ptr<FrictionFilter> filter,
                 const MarginOverTimeOptions& options);

  // What all frames up to this one say.
  struct Now {
    // |Q|/P, and friction by all frames.
    MeanSigma load, friction;
    // By both.
    MeanSigma margin;
    double relative() const noexcept { return friction.sigma / friction.mean; }
  };
  // Friction and |Q|/P as they stand; `margin`: of both, is kept within the bounds of friction, with the
  // floor of its sigma.
  Now now_with(MeanSigma margin, const MarginInput& frame) noexcept;
  // Friction as it stands bounds the margin.
  void rely_on_least(const MarginInput& frame, MarginDecision& decision) const noexcept;
  // Frames say nothing, or too little.
  static void refuse_unknown(const MarginInput& frame, MarginDecision& decision) noexcept;
  // Frames contradict every friction.
  static void refuse_contradicted(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept;
  void give_friction(const MeanSigma& friction, Estimate& out) const noexcept;
  // Proposes it, with what friction can carry if it means something.
  void propose(const MeanSigma& margin, const MarginInput& frame, MarginDecision& decision,
               Estimate& out) const noexcept;
  // Of a frame whose torque shows friction by itself (Reading::turning, in_model).
  MeanSigma by_itself(const Reading& reading, MarginDecision& decision, Estimate& out) const noexcept;
  // The frame's own margin, with the history that the likeliest friction's contact has had.
  MeanSigma own_margin(const Reading& reading) const noexcept;
  // `own` where it agrees with `margin`, by friction, and is the surer one.
  MeanSigma better_of(const MeanSigma& margin, const MeanSigma& own, const Reading& reading,
                      Estimate& out) const noexcept;

  // Standard deviation of friction, relative, by what all frames of a grasp have in common.
  double common_sigma(const MarginInput& frame) const noexcept;

  const MarginOverTimeOptions options_;
  const double sigma_max_;
  const Range bounds_;
  const std::unique_ptr<FrictionFilter> filter_;
  const MeanSigma prior_;  // of friction
  double last_friction_;   // its mean a frame ago
};

// Friction is learnt in each grasp.
class LearntFrictionMargin : public MarginOverTime {
 public:
  void forget() noexcept override {
    MarginOverTime::forget();
    unobserved_.forget();
  }

 protected:
  LearntFrictionMargin(double sigma_max, const FrictionKnowledge& friction, Range bounds,
                       std::unique_ptr<FrictionFilter> filter, const MarginOverTimeOptions& options);
  // Nothing if frames contradict every friction; then the margin is refused.
  std::optional<Now> learn(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept;
  // Adds to sigma what forces did between two frames.
  void widen_by_unobserved(const MarginInput& frame, MarginDecision& decision, const Estimate& out) noexcept;
  // What forces alone leave of the margin, on the safe side of its middle.
  MeanSigma minus_one_sigma(const Now& now, const MeanSigma& margin) const noexcept;
  // The filter's margin, or the lower one that a pad shows.
  MeanSigma with_shared(const MeanSigma& load, const MarginProfile* shared) const noexcept;
  bool has_settled(const Now& now) const noexcept { return now.relative() < kSettledFriction; }

 private:
  const double log_range_;       // of what was known before
  const double usual_friction_;  // while that of the grasp is not known
  UnobservedLoadChange unobserved_;
};

// Sensors whose single frames determine no margin.
class LearntByForces final : public LearntFrictionMargin {
 public:
  LearntByForces(double sigma_max, const FrictionKnowledge& friction,
                 const MarginOverTimeOptions& options = {});
  std::string_view name() const noexcept override { return "friction_by_forces"; }
  void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept override;

 private:
  MeanSigma within_bounds(const Now& now, const MeanSigma& margin) const noexcept;
};

// Pads whose taxels are tips of pillars: what each carries shows friction.
class LearntByPillars final : public LearntFrictionMargin {
 public:
  // Throws std::invalid_argument as PillarBeds does.
  LearntByPillars(double sigma_max, const TaxelLayout& layout, const FrictionKnowledge& friction,
                  const MarginOverTimeOptions& options = {});
  std::string_view name() const noexcept override { return "friction_by_pillars"; }
  void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept override;
};

// Sensors whose frames show margin and friction by themselves.
class LearntByShape final : public LearntFrictionMargin {
 public:
  LearntByShape(double sigma_max, const FrictionKnowledge& friction,
                const MarginOverTimeOptions& options = {});
  std::string_view name() const noexcept override { return "friction_by_shape"; }
  void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept override;

 private:
  MeanSigma by_memory(const Now& now, const Reading* reading) const noexcept;
  MeanSigma combine(const Now& now, const Reading& reading, Estimate& out) const noexcept;
};

// Friction was given as a value: what happened before the frame needs no history, and nothing of it is
// doubted.
class GivenFrictionMargin : public MarginOverTime {
 public:
  GivenFrictionMargin(double sigma_max, const FrictionKnowledge& friction,
                      std::unique_ptr<FrictionFilter> filter, const MarginOverTimeOptions& options);

 protected:
  // As LearntFrictionMargin::learn. by_forces: the history is not known, and friction answers alone.
  std::optional<Now> follow(const MarginInput& frame, MarginDecision& decision, Estimate& out,
                            bool& by_forces) noexcept;
};

class GivenByForces final : public GivenFrictionMargin {
 public:
  GivenByForces(double sigma_max, const FrictionKnowledge& friction,
                const MarginOverTimeOptions& options = {});
  std::string_view name() const noexcept override { return "given_friction"; }
  void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept override;
};

class GivenByShape final : public GivenFrictionMargin {
 public:
  GivenByShape(double sigma_max, const FrictionKnowledge& friction,
               const MarginOverTimeOptions& options = {});
  std::string_view name() const noexcept override { return "given_friction_and_shape"; }
  void estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept override;
};

// The source for a sensor. needs_history: its single frames determine no margin.
std::unique_ptr<MarginSource> make_margin_over_time(double sigma_max, const FrictionKnowledge& friction,
                                                    bool needs_history,
                                                    const MarginOverTimeOptions& options = {});

// The source for a pad of pillars. Throws std::invalid_argument as PillarBeds does.
std::unique_ptr<MarginSource> make_margin_of_pillars(double sigma_max, const TaxelLayout& layout,
                                                     const FrictionKnowledge& friction,
                                                     const MarginOverTimeOptions& options = {});

}  // namespace slipd
