#include "core/reading/torque/torque_reading.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {

void TorqueReading::forget() noexcept {
  slipping_.forget();
  path_.forget();
}

void TorqueReading::lose_sight() noexcept {
  forget();
  path_.lose_sight();
}

Reading TorqueReading::estimate(const ContactPatch& loaded, const EquivalentPullResult& pull) noexcept {
  Reading reading = slipping_.estimate(loaded);
  if (!slips_anew(reading, loaded.normal_n)) {
    reading.in_model = false;
    reading.load_fallen = true;
  } else if (frame_.path.straight && (!reading.in_model || reading.gamma > kRoundedGamma)) {
    const Reading by_moments = moments_.estimate(loaded, pull);
    if (!reading.in_model ||
        (by_moments.in_model && by_moments.sigma < reading.sigma &&
         std::fabs(by_moments.gamma - reading.gamma) < kClearSigmas * norm(by_moments.sigma, reading.sigma)))
      return by_moments;
  }
  return reading;
}

void TorqueReadingOverTime::forget() noexcept {
  TorqueReading::forget();
  torque_changed_shear_ = false;
  most_stuck_n_ = 0;
}

// A load beyond all that came before wipes what a torque has left.
bool TorqueReadingOverTime::torque_changes_shear(const EquivalentPullResult& pull) noexcept {
  const bool left = torque_changed_shear_ && !(path().risen && path().least_stuck);
  torque_changed_shear_ = pull.torque_effect == TorqueEffect::changes_shear || left;
  return torque_changed_shear_;
}

// Taxels that slipped under another load stick again at lower ratios, which end in a plateau as well. It is
// one of taxels that slip if earlier loads have left no trace, or if its ratios do not fall towards the rim,
// where slip begins. And where taxels carry clearly less than they did while they stuck, friction has fallen.
bool TorqueReadingOverTime::slips_anew(const Reading& plateau, double normal_n) noexcept {
  if (slipping().all_slipped()) return true;
  if (!path().risen) return false;
  if (path().straight || path().least_stuck) {
    most_stuck_n_ = 0;
    return true;
  }
  if (!slipping().rising()) return true;
  if (!plateau.in_model) return false;
  const double carried_n = plateau.friction * normal_n;
  most_stuck_n_ = std::max(most_stuck_n_, carried_n);
  return carried_n < kFallen * most_stuck_n_;
}

}  // namespace slipd
