// How the taxels of a flat pad share its shear. Flat pillars, and pieces of a flat skin, are contacts of
// their own (Winkler 1867): while an object is pulled, those that stick are sheared alike, by its shift, and
// those that slip carry their friction. So a pad that sticks shares the pull evenly, and one that slips
// shares it as it shares the pressure: taxels that are pressed least slip first. What lies between shows how
// much of its friction the pad has used up, before it slides (docs/theory.md, "Taxels that slip first").
//
// Only pull that has come since P last rose counts. A gripper that closes askew presses and shears each taxel
// at once, in proportion, and so does rubber that leans; both look like slip and stick.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/estimate/method.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Checked with `sliplab alerts`. P: the normal force, Q: the shear force; shares have no unit.
struct SharedShearOptions {
  // P that rises by this share above its least begins anew; 0.02 … 0.2. Too small: shaking. Too large: shear
  // of pressing passes for a pull.
  double normal_rise = 0.05;
  // P that falls by this share while nothing pulls: the field of the hold is taken anew; 0.05 … 0.5.
  double normal_fall = 0.1;
  // Pull over P from which on something pulls; 0.01 … 0.1. Too small: noise. Too large: a slow pull passes
  // for the field of the hold.
  double pulled = 0.03;
  // Pull over P from which on it is read; 0.05 … 0.3. Too small: uneven rubber passes for slip. Too large:
  // slips on slippery objects come unseen.
  double least_pull = 0.2;
  // The same in standard deviations of Q; 3 … 20.
  double pull_sigmas = 6;
  // A pull below this share of the greatest one has fallen, and is not read; 0.7 … 1.
  double fallen = 0.9;
  // Standard deviations of what a taxel carries: of that, and of the mean of all; 0.05 … 0.5. Too small:
  // rubber of uneven stiffness passes for slip. Too large: nothing is learnt.
  double uneven_share = 0.15;
  double uneven_mean = 0.1;
  // Mean squared misfit of a taxel above which taxels do not stand alone but under a layer; 0.3 … 1.
  double most_misfit = 0.6;
  // A layer spreads what it passes on, so only how far the pattern of shear has gone since the pull began is
  // read: as a share of what it would be without the layer, 0.3 … 1, and the standard deviation of that
  // share's logarithm, 0.2 … 1.
  double spread_share = 0.5;
  double spread_sigma = 0.4;
  // Standard deviation of that way, root mean square over the taxels: of the mean of all, 0.01 … 0.1, and of
  // the pressure's unevenness, 0.02 … 0.3.
  double way_sigma = 0.03;
  double way_sigma_share = 0.05;
  // Standard deviation, over taxels, of what they carry of a pull that begins; of the mean; 0.1 … 0.5.
  double stiffness_sigma = 0.3;
};

// Not thread-safe. Belongs to the estimate thread; fixed memory, nothing allocates.
class SharedShear {
 public:
  // With fewer there is no pattern; with more, taxels are no contacts of their own.
  static constexpr std::size_t kLeastTaxels = 6, kMostTaxels = 64;

  // Throws std::invalid_argument if the layout has fewer taxels than kLeastTaxels, or more than kMostTaxels.
  explicit SharedShear(const TaxelLayout& layout, const SharedShearOptions& options = {});

  // One frame in contact, in order of time. How little each margin fits it, of Gamma = 1 - Q/(mu P) with the
  // Q and P of `patch`; not known where the frame says nothing.
  const MarginProfile& update(const ContactPatch& patch) noexcept;

  // The contact was lost.
  void forget() noexcept { state_ = {}; }

 private:
  using PerTaxel = std::array<double, kMostTaxels>;
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
    double begun_n = 0;
    int begun_frames = 0;
    PerTaxel begun{};
    double highest = 0;  // the greatest pull over P
  };
  // What came upon the field of the hold.
  struct Pull {
    double x_n = 0, y_n = 0;
    double size_n = 0;
  };
  double read_normal(const ContactPatch& patch) noexcept;
  Pull read_pull(const ContactPatch& patch, double noise_n) noexcept;
  void learn_field(const ContactPatch& patch, double normal_n) noexcept;
  void learn_begin(double pull_n) noexcept;
  void weigh(double load, double pull, double pull_n, double noise_n) noexcept;
  void share_out(double used, PerTaxel& carried) const noexcept;
  double square_way(double noise_n, double pull_n) const noexcept;

  SharedShearOptions options_;
  std::size_t taxels_;
  double area_m2_;
  State state_;
  PerTaxel normal_n_{};                            // of this frame
  PerTaxel pull_x_n_{}, pull_y_n_{};               // the same
  PerTaxel pressed_{}, pulled_{};                  // shares of P, and of the pull along its direction
  std::array<std::uint8_t, kMostTaxels> order_{};  // taxels by their normal force
  MarginProfile profile_;
};

}  // namespace slipd
