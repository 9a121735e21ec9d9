// One contact of what core/estimate/winkler_foundations follows many of, in its plain form: what the other is
// held against, to the last bit, and what is itself held against the exact history.
#pragma once

#include <array>
#include <cstddef>

#include "core/contact/shear_moments.hpp"

namespace slipd::contact {

class WinklerFoundation {
 public:
  // As of WinklerFoundations, but for the friction, which is told each time.
  void clear() noexcept;
  void follow(double normal_n, double shear_n, double friction) noexcept;
  void assume_monotonic(double normal_n, double shear_n, double friction) noexcept;

  double shear_n() const noexcept { return shear_n_; }

  ShearMoments shear_moments() const noexcept;

 private:
  static constexpr std::size_t kSprings = 48;
  using Row = std::array<float, kSprings>;

  void reach(double radius) noexcept;
  void limits(double edge, double friction, Row& most) const noexcept;
  void settle(const Row& most, double target) noexcept;
  double touching(double edge) const noexcept;

  double step_ = 0;  // between springs; spring i stands at (i + 1/2) step
  double normal_n_ = 0, shear_n_ = 0;
  Row load_{};  // what each carries
};

}  // namespace slipd::contact
