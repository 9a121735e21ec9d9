// The shear of one frame as a sum of a few maps of its closing, whatever the load went through
// (docs/methods.md §25.3). A history of loads leaves a sum of signed mu p(P_i) with the pressures p of the
// contact under smaller forces P_i (Jäger 1998), as it leaves a sum of discs in a Hertz contact. So each map
// counts for the disc of its force, whatever its shape is, and the shear moments are those that friction's
// foundations follow. Estimate thread; nothing allocates.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>

#include "core/contact/shear_moments.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

class JaegerDecomposition {
 public:
  static constexpr std::size_t kTerms = contact::kDiscRadii.size();
  // The force of a term's map, over the frame's: of a Hertzian contact of that radius.
  static constexpr double share_of(std::size_t term) noexcept {
    const double radius = contact::kDiscRadii[term];
    return radius * radius * radius;
  }
  using Terms = Eigen::Matrix<double, static_cast<int>(kTerms), 1>;
  using Products = Eigen::Matrix<double, static_cast<int>(kTerms), static_cast<int>(kTerms)>;

  // normal_n: the frame's force, > 0.
  explicit JaegerDecomposition(double normal_n) noexcept : normal_n_(normal_n) {}

  // A part `weight` of the recorded map of the force map_n, N, is in a term.
  void add(std::size_t term, double map_n, double weight) noexcept;

  // What is read, and noise. All sums are over the same values.
  struct Read {
    Products products;         // of terms, Pa^2
    Products noise_shares;     // products of their noise, over noise of a value of one frame
    Terms sensed;              // products of terms and shear, Pa^2
    double shear_pa2 = 0;      // sum of squares of the shear
    double values = 0;         // their number
    double noise_pa2 = 0;      // variance of one value, > 0
    double map_noise_pa2 = 0;  // the same of a map of one frame
  };

  // By least squares; no term carries much more than P. False: the terms are not independent.
  bool solve(const Read& read) noexcept;

  // Of what was solved: friction times each term.
  const Terms& friction() const noexcept { return friction_; }
  // The frame's forces, across the contact and along the shear, N.
  double normal_n() const noexcept { return normal_n_; }
  double shear_n() const noexcept { return shear_n_; }
  // The moments and their deviations by noise: with that which all frames of one closing have in common, and
  // that alone.
  void give_moments(Reading& out) const noexcept;
  // Sum of squares that is left beyond noise, Pa^2; a mean of 0 where the maps explain the shear.
  double excess_pa2() const noexcept { return excess_pa2_; }

 private:
  double normal_n_;
  // What one unit of friction on each term carries, N.
  Terms force_n_ = Terms::Zero(), slip_n_ = Terms::Zero(), legendre_n_ = Terms::Zero();
  Terms friction_ = Terms::Zero();
  double shear_n_ = 0, excess_pa2_ = 0;
  contact::ShearMoments moments_,
      sigma_{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}, common_sigma_;
};

}  // namespace slipd
