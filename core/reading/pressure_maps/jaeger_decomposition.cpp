#include "core/reading/pressure_maps/jaeger_decomposition.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/frame/model_errors.hpp"

namespace slipd {
namespace {

// Friction of a term, standard deviation: traction between two of them is at most twice the contact's; 0.3 …
// 1. Too small: reversed loads come out too small. Too large: the moments' deviations are too large.
constexpr double kUsualFriction = 0.5;

}  // namespace

void JaegerDecomposition::add(std::size_t term, double map_n, double weight) noexcept {
  const auto i = static_cast<Eigen::Index>(term);
  const double force_n = weight * map_n, u = std::pow(map_n / normal_n_, 2.0 / 3);  // of its disc, x^2
  force_n_[i] += force_n;
  const contact::ShearMoments of_disc = contact::moments_of_disc(u);
  slip_n_[i] += force_n * of_disc.slip_moment_n;
  legendre_n_[i] += force_n * of_disc.second_legendre_n;
}

void JaegerDecomposition::give_moments(Reading& out) const noexcept {
  out.moments = moments_;
  out.moments_sigma = sigma_;
  out.moments_common_sigma = common_sigma_;
}

bool JaegerDecomposition::solve(const Read& read) noexcept {
  const Products products = read.products / read.noise_pa2,
                 by_noise = read.values * read.map_noise_pa2 / read.noise_pa2 * read.noise_shares;
  Products information = products;
  information.diagonal().array() += 1 / (kUsualFriction * kUsualFriction);
  const Eigen::LDLT<Products> solved(information);
  if (solved.info() != Eigen::Success || !solved.isPositive()) return false;
  friction_ = solved.solve(read.sensed / read.noise_pa2);
  shear_n_ = friction_.dot(force_n_);
  const double maps =
      read.map_noise_pa2 * friction_.dot(read.noise_shares.lazyProduct(friction_)) / read.noise_pa2;
  excess_pa2_ = read.shear_pa2 - 2 * friction_.dot(read.sensed) +
                friction_.dot(read.products.lazyProduct(friction_)) -
                read.values * read.noise_pa2 * (1 + maps);
  moments_ = {friction_.dot(slip_n_), friction_.dot(legendre_n_)};
  const double floor_n = kUnevenShare * std::fabs(shear_n_);
  const auto sigma_of = [&](const Terms& of, double at_least_n, double& common_n) {
    const Terms by = solved.solve(of);
    const double own_n2 = std::max(0.0, by.dot(products.lazyProduct(by)));
    const Terms drawn = kUsualFriction * by_noise.lazyProduct(by) + by / kUsualFriction;
    common_n = std::sqrt(maps * own_n2 + drawn.squaredNorm() + at_least_n * at_least_n);
    return std::sqrt(own_n2 + common_n * common_n);
  };
  sigma_.slip_moment_n = sigma_of(slip_n_, floor_n, common_sigma_.slip_moment_n);
  sigma_.second_legendre_n = sigma_of(legendre_n_, 2 * floor_n, common_sigma_.second_legendre_n);
  return true;
}

}  // namespace slipd
