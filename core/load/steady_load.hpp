// A contact's forces as all frames since they last turned show them: held, or on a straight line. Noise of
// single frames is averaged out, the further the longer nothing turns; a load that turns begins anew. That is
// told by a generalized likelihood ratio test (Basseville and Nikiforov, Detection of Abrupt Changes, 1993,
// section 2.4.3): the latest 1, 2, 4 … frames against the line of those before. Estimate thread; fixed
// memory, nothing allocates.
#pragma once

#include <array>
#include <cstddef>

#include "core/load/load_path.hpp"

namespace slipd {

class SteadyLoad {
 public:
  // Each frame in contact, in order of time. Standard deviations of its noise, N, >= 0: of P, and of shear
  // along any axis. Without noise each frame stands for itself.
  void follow(const ContactForces& forces, double normal_sigma_n, double shear_sigma_n) noexcept;

  // At the newest frame, N. P > 0 if all frames' are.
  const ContactForces& now() const noexcept { return now_; }
  // Standard deviation of now(), of one frame's noise: 1 after a turn, then less; 0 … 1.
  double noise_share() const noexcept { return noise_share_; }

 private:
  // The longest span that is tested: a turn that it does not show is less than one frame's noise.
  static constexpr std::size_t kLongest = 32;
  static constexpr std::size_t kKept = 2 * kLongest;  // a power of two

  // Sums over the frames since the last turn, which are counted from 1 on.
  struct Sums {
    ContactForces forces, by_frame;  // of the forces, N, and of the forces times the frame's number
  };
  Sums& sums_before(std::size_t frames) noexcept { return sums_[(newest_ - frames) % kKept]; }
  void begin_with_latest(std::size_t frames) noexcept;  // at most kLongest

  std::size_t frames_ = 0, newest_ = 0;
  std::array<Sums, kKept> sums_{};  // up to the newest frame, and to those before it
  ContactForces now_;
  double noise_share_ = 1;
};

}  // namespace slipd
