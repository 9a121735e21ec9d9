// Friction of one grasp, frame by frame (docs/methods.md §28). A frame takes weight from frictions whose
// contact would look otherwise. What no frame distinguishes stays open: a contact that sticks all over looks
// the same for every friction that holds it. This class has what all sensors need; by_forces.hpp and
// by_shape.hpp read frames. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/frame/significance.hpp"
#include "core/friction/friction_filter_options.hpp"
#include "core/friction/friction_posterior.hpp"
#include "core/friction/history_state.hpp"
#include "core/friction/traction_ratio.hpp"
#include "core/load/load_path.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

// A frame as friction is learnt from it.
struct FrictionFrame {
  // With the forces that act. Where a torque has changed the field (reading->under_torque) its shear_n is the
  // pull that asks for as much of friction.
  const ContactPatch& patch;
  // From the frame before to this one.
  const LoadStep& step;
  // Null where the frame has no shape.
  const Reading* reading = nullptr;
  // The object's sliding, a frame ago.
  const SlidingVerdict& previous;
};

class FrictionFilter {
 public:
  virtual ~FrictionFilter() = default;

  // One frame in contact, in order of time.
  virtual void update(const FrictionFrame& frame) noexcept = 0;
  // A new grasp: back to the prior.
  virtual void reset() noexcept = 0;
  // The same, and the contact may carry a load already.
  virtual void lose_sight() noexcept { reset(); }

  // |Q|/P now.
  const MeanSigma& traction_ratio() const noexcept { return traction_ratio_.now(); }
  // What a frame's margin, read as one of a monotonic load, misses by the history that the likeliest
  // friction's contact has had: to be added to it, Gamma; and its standard deviation.
  virtual MeanSigma margin_offset() const noexcept { return {}; }
  // The course of the forces explains why frames say nothing of friction, if they say nothing: friction
  // learnt before may answer for them. Not so when shear was lost in one step, or when frames with a clear
  // shear have said nothing for long.
  virtual bool explained() const noexcept { return true; }
  // A clear shear vanished from one frame to the next, by more than an unloading explains.
  virtual bool shear_lost() const noexcept { return false; }
  // The history is known, and frames of late look as some friction would make them.
  virtual bool understood() const noexcept { return is_known(history()) && explained_of_late(); }

  // Standard deviation of friction, relative, by what all frames of a grasp have in common with this contact;
  // 0: no more than is usual.
  virtual double common_sigma(const ContactPatch& /*patch*/) const noexcept { return 0; }

  // This frame contradicts the friction that was likeliest before it: friction has changed, or was wrong.
  bool surprised() const noexcept { return posterior_.surprise() > kClearSigmas * kClearSigmas; }

  // The posterior of friction.
  const FrictionGrid& grid() const noexcept { return posterior_.grid(); }
  // What is known of the load before this frame.
  HistoryState history() const noexcept { return history_.state(); }

 protected:
  using PerFriction = std::array<double, FrictionGrid::kMost>;

  FrictionFilter(const FrictionPrior& prior, std::size_t points, const FrictionFilterOptions& options);

  void reset_evidence() noexcept;
  // The first call for each frame: time goes on, and errors are others where the forces have moved far.
  void begin_frame(const FrictionFrame& frame) noexcept;
  // Coulomb: friction is at least the load that it holds.
  void bound_by_held() noexcept;
  // The load is less than it was a frame ago, > 0 s: it is held and noise is all of the fall, it was let go,
  // or friction has fallen to it. Forces alone do not tell, and the densities of the three are weighed. load:
  // now; drop: in friction limits, > 0.
  void weigh_drop(const MeanSigma& load, const MeanSigma& drop, double seconds) noexcept;
  // Of a frame that friction is read from. residuals: see FrictionPosterior::weigh.
  void weigh_margin(std::span<const double> residuals, const Reading& reading, double offset_sigma,
                    double utilisation) noexcept;
  void weigh_profile(const MarginProfile& profile, double load) noexcept;
  // Counts the frame, of this least squared residual. False: nothing explains it.
  bool explain(double least_squared, bool confirms_monotonic) noexcept;
  bool explained_of_late() const noexcept { return mean_residual_ < options_.max_mean_residual; }
  // The load before is not known any more.
  virtual void lose_history(HistoryEvent why) noexcept;
  double likeliest() const noexcept { return grid().friction(grid().likeliest()); }

  const FrictionFilterOptions options_;
  FrictionPosterior posterior_;
  HistoryMonitor history_;
  TractionRatioFilter traction_ratio_;

 private:
  double mean_residual_ = 1;  // of the best friction, squared
};

}  // namespace slipd
