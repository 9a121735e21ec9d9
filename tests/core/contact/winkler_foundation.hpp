// One Winkler foundation in its plain form. core/friction/foundations/winkler_foundations follows many of
// them and must agree with this one; this one must agree with the exact load history.
#pragma once

#include <array>
#include <cstddef>

#include "core/contact/shear_moments.hpp"

namespace slipd::contact {

class WinklerFoundation {
 public:
  // As in WinklerFoundations, but each call takes the friction.
  void clear() noexcept;
  void follow(double normal_n, double shear_n, double friction) noexcept;
  void assume_monotonic(double normal_n, double shear_n, double friction) noexcept;
  // Springs that carry more than this friction holds slip down to that; what all carry is for follow() to
  // restore.
  void fall_to(double friction) noexcept;

  double shear_n() const noexcept { return shear_n_; }

  ShearMoments shear_moments() const noexcept;

 private:
  static constexpr std::size_t kSprings = 48;
  using Row = std::array<float, kSprings>;

  void reach(double radius) noexcept;
  void limits(double edge, double friction, Row& most) const noexcept;
  void settle(const Row& most, double target) noexcept;
  double touching(double edge) const noexcept;

  double step_ = 0;  // distance between springs; spring i is at (i + 1/2) step
  double normal_n_ = 0, shear_n_ = 0;
  Row load_{};  // shear that each spring carries
};

}  // namespace slipd::contact
