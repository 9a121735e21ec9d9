// Friction of one grasp: a Bayes filter on a grid of log mu (docs/methods.md §28). A frame takes weight from
// frictions whose contact would look otherwise. What no frame distinguishes stays open: a contact that sticks
// all over looks the same for every friction that holds it. A change of friction is learnt within a few
// frames, and sooner if it fell than if it rose. This class has what all sensors need; by_forces.hpp and
// by_shape.hpp read frames. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/friction/friction_filter_options.hpp"
#include "core/friction/friction_grid.hpp"
#include "core/friction/history_state.hpp"
#include "core/load/load_path.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

// A frame as friction is learnt from it.
struct FrictionFrame {
  // CLOCK_MONOTONIC, ns.
  std::int64_t time_ns = 0;
  // With the forces that act. Where a torque has changed the field (reading->under_torque) its shear_n is the
  // pull that asks for as much of friction.
  const ContactPatch& patch;
  // From the frame before to this one, as measured.
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
  const MeanSigma& traction_ratio() const noexcept { return frame_.traction_ratio; }
  // What a frame's margin, read as one of a monotonic load, misses by the history that the likeliest
  // friction's contact has had: to be added to it, Gamma; and its standard deviation.
  virtual MeanSigma margin_offset() const noexcept { return {}; }
  // Frames of late contradict the likeliest friction a little: it is less than it was, and they do not say by
  // how much.
  virtual bool doubted() const noexcept { return false; }
  // The course of the forces explains why frames say nothing of friction, if they say nothing: friction
  // learnt before may answer for them. Not so when shear was lost in one step, or when frames with a clear
  // shear have said nothing for long.
  virtual bool explained() const noexcept { return true; }
  // A clear shear vanished from one frame to the next, by more than an unloading explains.
  virtual bool shear_lost() const noexcept { return false; }
  // Friction has fallen in this grasp, as far as frames then left it open.
  virtual bool fallen() const noexcept { return false; }
  // The history is known, and frames of late look as some friction would make them.
  virtual bool understood() const noexcept {
    return is_known(history()) && evidence_.mean_residual < options_.max_mean_residual;
  }

  // The posterior of friction.
  const FrictionGrid& grid() const noexcept { return grid_; }
  // What is known of the load before this frame.
  HistoryState history() const noexcept { return history_.state(); }
  // This frame contradicts the friction that was likeliest before it: friction has changed, or was wrong.
  bool surprised() const noexcept { return frame_.surprised; }

 protected:
  using PerFriction = std::array<double, FrictionGrid::kMost>;

  FrictionFilter(const FrictionPrior& prior, std::size_t points, const FrictionFilterOptions& options);

  // Page's cumulative sum of evidence that friction has changed.
  struct Cusum {
    double nats = 0;
    void add(double evidence_nats, double drift_nats) noexcept {
      nats = std::max(0.0, nats + evidence_nats - drift_nats);
    }
  };

  // Evidence of margin profiles so far, in units of what all of them have in common.
  struct EvidenceDiscount {
    double common = 0;
    void add(double sigmas) noexcept { common += sigmas * sigmas; }
    double share() const noexcept { return 1 / (1 + common); }
  };

  // Frames of one contact share a part of their error (docs/methods.md §28.2): what n of them say of friction
  // has the variance common^2 + noise^2/n, relative to friction.
  struct CommonError {
    // What the frames so far said, as the inverse of that variance; faded as the contact changes.
    double known = 0;
    double mean = 0;  // of the common sigma over the frames so far; 0: none yet
    // That mean before this frame, of which `sigma` is the common sigma. A frame's own would be larger or
    // smaller with its noise, and so would its weight.
    double usual(double sigma, double gain) noexcept {
      const double before = mean > 0 ? mean : sigma;
      mean = before + gain * (sigma - before);
      return before;
    }
    // Adds a frame of variances `common` and `noise` > 0. Returns how much of its evidence is new, 0 … 1.
    double add(double common, double noise) noexcept {
      const double open = 1 / std::max(known, kLeast) - common;
      if (!(open > 0)) return 0;
      const double with_it = 1 / (common + 1 / (1 / open + 1 / noise)),
                   share = (with_it - known) * (common + noise);
      known = with_it;
      return std::clamp(share, 0.0, 1.0);
    }
    static constexpr double kLeast = 1e-9;  // of known: nothing was said
  };

  // What frames of this grasp have said, beside the weights.
  struct Evidence {
    double mean_residual = 1;  // of the best friction, squared
    Cusum cusum;
    EvidenceDiscount discount;
    CommonError of_margins, of_moments;
    double normal_n = 0, shear_n = 0;  // forces of the last frame that was weighed
  };

  void reset_evidence() noexcept;
  // The frames before say nothing of what the next ones have in common.
  void forget_common() noexcept;
  // What frames have in common changes with the contact: where the forces have moved far, errors are new.
  void part_errors(const ContactPatch& patch) noexcept;
  // How much of a frame's margin is new evidence, 0 … 1.
  double share_of_margin(double load, const Reading& reading) noexcept;
  // Squared residual of a friction by the frame's margin, with the history that its contact has had.
  double margin_residual(std::size_t friction, double load, const Reading& reading,
                         const MeanSigma& offset) const noexcept;
  // Bayes: half of each friction's squared residual is taken from its log weight, unless nothing explains the
  // frame: then false. `share`: how much of it is new.
  bool take_evidence(const PerFriction& residuals, bool confirms_monotonic, double share) noexcept;
  // The load before is not known any more.
  virtual void lose_history(HistoryEvent why) noexcept;
  // Coulomb: friction is at least the |Q|/P that it holds. `frames`: for how many frames' evidence it counts.
  void bound_below(const MeanSigma& load, double frames) noexcept;

  const FrictionFilterOptions options_;
  FrictionGrid grid_;
  HistoryMonitor history_;
  Evidence evidence_;
  struct ThisFrame {
    MeanSigma traction_ratio;  // |Q|/P
    bool surprised = false;    // see surprised()
  };
  ThisFrame frame_;
};

}  // namespace slipd
