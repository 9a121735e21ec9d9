// How the taxels of a flat pad share its shear. Flat pillars, and pieces of a flat skin, are contacts of
// their own (Winkler 1867): while an object is pulled, those that stick are sheared alike, by its shift, and
// those that slip carry their friction. So a pad that sticks shares the pull evenly, and one that slips
// shares it as it shares the pressure: taxels that are pressed least slip first. What lies between shows how
// much of its friction the pad has used up, before it slides (docs/methods.md §29.4).
//
// Taxels under a layer share a pull alike, but sense it spread: of those only the way counts that their
// pattern has gone since the pull began.
//
// Only pull that has come since P last rose counts. A gripper that closes askew presses and shears each taxel
// at once, in proportion, and so does rubber that leans; both look like slip and stick.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Checked with `slipd-lab alerts`. P: the normal force, Q: the shear force; shares have no unit.
struct PadLoadSharingOptions {
  // Pull over P from which on it is read; 0.05 … 0.3. Too small: uneven rubber passes for slip. Too large:
  // slips on slippery objects come unseen.
  double least_pull = 0.2;
  // Standard deviation over the pad of what a taxel that stands alone carries, of friction (one half is above
  // its mean, the other below), and of what a layer passes on along a pull and across it; 0.05 … 0.5. Too
  // small: uneven rubber passes for slip, and a pad that is pressed evenly slips unseen. Too large: nothing
  // is learnt, and pads seem to slip early.
  double uneven = 0.12;
  // Mean squared misfit of a taxel from which on taxels are likelier to lie under a layer than to stand
  // alone; 0.5 … 3. Too small: a pillar that is unlike its neighbours passes for a layer. Too large: the
  // other way.
  double most_misfit = 1.5;
  // A layer evens out the pressure that acts on it, more where it is more uneven: what acts is the share that
  // is sensed to this power; 1 … 2. Too small: the first slip is seen late. Too large: it is taken for none.
  double spread_pressure = 1.2;
  // It evens out shear more than pressure: of how far the pattern goes on its surface, root mean square over
  // the taxels, they sense this share, 0.1 … 1. A half space passes on 0.27 … 0.6 of what it passes on of the
  // pressure, as deep as 0.3 … 0.9 of a pitch, of waves from one to ten pitches.
  double spread_shear = 0.4;
  // Standard deviation of the logarithm of that way; 0.2 … 1. Too small: a way that is sensed by more than
  // most is a false alert. Too large: no margin is clear.
  double way_sigma = 0.4;
  // Way that a pattern goes without slip: of the mean, 0.005 … 0.05; of the pressure's unevenness, 0.02 …
  // 0.2, for shear of pressing; and `uneven` of the sine of the angle by which the pull has turned. Too
  // small: false alerts. Too large: slip of evenly pressed pads is not seen.
  double still_way = 0.01;
  double still_way_share = 0.05;
};

// Not thread-safe. Belongs to the estimate thread; fixed memory, nothing allocates.
class PadLoadSharing {
 public:
  // With fewer there is no pattern; with more, taxels are no contacts of their own.
  static constexpr std::size_t kLeastTaxels = 6, kMostTaxels = 64;

  // Throws std::invalid_argument if the layout has fewer taxels than kLeastTaxels, or more than kMostTaxels.
  explicit PadLoadSharing(const TaxelLayout& layout, const PadLoadSharingOptions& options = {});

  // One frame in contact, in order of time, and its patch. Taxels are read from the frame itself: a hollow of
  // the object is no dead taxel. How little each margin fits it, of Gamma = 1 - Q/(mu P) with the Q and P of
  // `patch`; not known where the frame says nothing.
  const MarginProfile& update(const Frame& frame, const ContactPatch& patch) noexcept;

  // The contact was lost.
  void forget() noexcept { state_ = {}; }

 private:
  using PerTaxel = std::array<double, kMostTaxels>;
  using Misfits = std::array<double, MarginProfile::kSteps>;
  // Of the hold before the pull: sums over frames, of each taxel's forces times its normal force, N^2.
  struct Field {
    int frames = 0;
    double normal_n = 0;  // P of the first one
    PerTaxel x{}, y{}, squares{};
  };
  struct State {
    Field field;
    double least_normal_n = 0;
    bool pulled = false;
    // While the pull is too small to be read: its sum over frames, and each taxel's part of it.
    double begun_n = 0, begun_x_n = 0, begun_y_n = 0;
    double begun_share = 0;  // the same of the pull over P times the pull, N
    int begun_frames = 0;
    PerTaxel begun{};
    double highest = 0;  // the greatest pull over P
  };
  // What came upon the field of the hold.
  struct Pull {
    double x_n = 0, y_n = 0;
    double size_n = 0;
  };
  // Ascending shares of what friction holds, two of each taxel.
  using Limits = std::array<double, 2 * kMostTaxels>;
  // A frame with a pull, as weigh() takes it.
  struct Loads {
    double load = 0;  // |Q|/P
    double pull = 0;  // of that, what came upon the hold
    double noise_n = 0;
    // Of what friction holds of a pull over P, the share that `pull` uses up at the margin of step j.
    double used(double pull_share, std::size_t j) const noexcept {
      const double friction = load / (1 - MarginProfile::gamma_of(j));
      return std::min(1.0, pull_share / (friction - load + pull));
    }
  };
  // How far the pattern has gone since the pull began, and goes without slip: mean squares, of the mean.
  struct Way {
    double gone = 0, still = 0;
  };
  double read_normal(const Frame& frame) noexcept;
  Pull read_pull(const Frame& frame, double noise_n) noexcept;
  void learn_field(const Frame& frame, double normal_n) noexcept;
  void learn_begin(const Pull& pull, double share) noexcept;
  void weigh(const Loads& loads, const Pull& pull) noexcept;
  void compare_pattern(const Loads& loads, const Pull& pull, Misfits& alone) const noexcept;
  void compare_way(const Loads& loads, const Way& way, Misfits& alone, Misfits& under_layer) const noexcept;
  void find_limits(double power, Limits& limits) const noexcept;
  double way_between(const Limits& limits, double used, double used_before) const noexcept;
  Way way_of(const Pull& pull, double noise_n) const noexcept;

  const PadLoadSharingOptions options_;
  const std::size_t taxels_;
  const double area_m2_;
  State state_;
  struct ThisFrame {
    PerTaxel normal_n{}, pull_x_n{}, pull_y_n{};
    PerTaxel pressed{}, pulled{};  // shares of P, and of the pull along its direction
    MarginProfile profile;
  };
  ThisFrame frame_;
};

}  // namespace slipd
