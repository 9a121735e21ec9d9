#include "core/reading/torque/torque_reading.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

// Margin under torque from which on taxels that nearly slip round off the plateau of those that slip, 0.3 …
// 0.7: moments answer where both agree within so many standard deviations, 1 … 4. Too small: moments are
// computed for nothing. Too large: margins are too low.
constexpr double kRoundedGamma = 0.45, kAlikeSigmas = 2.5;

// What a plateau's ratio holds, over the most of it while its taxels stuck, below which friction has fallen;
// 0.8 … 0.98. Too small: friction that fell after a regrip is seen late. Too large: a load that turns is
// taken for a fall, and margins are too low.
constexpr double kFallenShare = 0.93;

}  // namespace

TorqueReading::TorqueReading(const TaxelLayout& layout, bool tracking)
    : slipping_(layout), moments_(layout), tracking_(tracking) {}

void TorqueReading::forget() noexcept {
  bent_ = false;
  most_stuck_n_ = 0;
  slipping_.forget();
}

// A load beyond all that came before wipes what a torque has left.
bool TorqueReading::bent(const EquivalentPullResult& load) noexcept {
  const bool left = tracking_ && bent_ && !(load.risen && load.least_stuck);
  bent_ = load.turning == Turning::bending || left;
  return bent_;
}

// Taxels that slipped under another load stick again at lower ratios, which end in a plateau as well. It is
// one of taxels that slip if earlier loads have left no trace, or if its ratios do not fall towards the rim,
// where slip begins. And where taxels carry clearly less than they did while they stuck, friction has fallen.
bool TorqueReading::slips_anew(const Reading& estimate, double normal_n,
                               const EquivalentPullResult& load) noexcept {
  if (!tracking_ || slipping_.all_slipped()) return true;
  if (!load.risen) return false;
  if (load.straight || load.least_stuck) {
    most_stuck_n_ = 0;
    return true;
  }
  if (!slipping_.rising()) return true;
  if (!estimate.in_model) return false;
  const double carried_n = estimate.friction * normal_n;
  most_stuck_n_ = std::max(most_stuck_n_, carried_n);
  return carried_n < kFallenShare * most_stuck_n_;
}

Reading TorqueReading::estimate(const ContactPatch& loaded, const EquivalentPullResult& load) noexcept {
  Reading estimate = slipping_.estimate(loaded);
  if (!slips_anew(estimate, loaded.normal_n, load)) {
    estimate.in_model = false;
    estimate.load_fallen = true;
  } else if (load.straight && (!estimate.in_model || estimate.gamma > kRoundedGamma)) {
    const Reading by_moments = moments_.estimate(loaded, load);
    if (!estimate.in_model || (by_moments.in_model && by_moments.sigma < estimate.sigma &&
                               std::fabs(by_moments.gamma - estimate.gamma) <
                                   kAlikeSigmas * std::hypot(by_moments.sigma, estimate.sigma)))
      return by_moments;
  }
  return estimate;
}

}  // namespace slipd
