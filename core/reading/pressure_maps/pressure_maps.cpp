#include "core/reading/pressure_maps/pressure_maps.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"

namespace slipd {

PressureMaps::PressureMaps(const TaxelLayout& layout, Range friction_expected,
                           const PressureMapsOptions& options)
    : layout_(layout),
      options_(options),
      maps_(layout.size()),
      shear_pa_(layout.size()),
      trials_({.expected = friction_expected, .spread = options.prior.scene_spread}) {}

void PressureMaps::observe(const Frame&, const ContactPatch& patch) noexcept {
  if (!(patch.normal_n > 0) || patch.normal_n < kStandsOutSigmas * patch.normal_sigma_n) return;
  if (maps_.frames_like(patch.normal_n) >= learning_frames()) return;
  const bool pulled =
      patch.shear_n > kPulled * patch.normal_n && patch.shear_n > kClearSigmas * patch.shear_sigma_n;
  if (!pulled || grown(patch)) maps_.add(patch.taxels, patch.normal_n);
}

bool PressureMaps::grown(const ContactPatch& patch) noexcept {
  if (!recorded(patch.normal_n) || patch.normal_n <= maps_.force_n(maps_.size() - 1)) return false;
  maps_.find_contact(patch.noise_normal_pa);
  return unmoved(patch, maps_.at(patch.normal_n));
}

bool PressureMaps::recorded(double normal_n) const noexcept {
  return maps_.size() >= options_.least_maps && maps_.force_n(0) <= normal_n / kGrown &&
         normal_n <= options_.most_step * maps_.force_n(maps_.size() - 1);
}

bool PressureMaps::unmoved(const ContactPatch& patch, const RecordedMaps::Sum& today) const noexcept {
  const std::span<const float> pressure(patch.taxels.normal_pa, layout_.size());
  const double noise_pa2 = patch.noise_normal_pa * patch.noise_normal_pa;
  double square_pa2 = 0;
  for (const float value : pressure) square_pa2 += static_cast<double>(value) * value;
  square_pa2 -= static_cast<double>(layout_.size()) * noise_pa2;
  const double map_pa2 = maps_.square_pa2(today, patch.noise_normal_pa);
  const double product_pa2 = RecordedMaps::product(today, maps_.products(pressure));
  if (!(square_pa2 > 0 && map_pa2 > 0)) return false;
  return 1 - product_pa2 * product_pa2 / (square_pa2 * map_pa2) < kUnlike;
}

MarginTrial PressureMaps::judge(double gamma, const ContactPatch& patch, const RecordedMaps::Sum& today,
                                const RecordedMaps::PerMap& products,
                                double shear_square_pa2) const noexcept {
  const RecordedMaps::Sum slipping = RecordedMaps::difference(today, maps_.at(gamma * patch.normal_n));
  const double product_pa2 = RecordedMaps::product(slipping, products);
  const double square_pa2 = maps_.square_pa2(slipping, patch.noise_normal_pa);
  MarginTrial trial{.gamma = gamma};
  if (!(square_pa2 > 0)) return trial;
  const double measured = product_pa2 / square_pa2, friction = std::max(0.0, measured);
  const double shear_pa2 = patch.noise_shear_pa * patch.noise_shear_pa;
  const double map_pa = friction * patch.noise_normal_pa;
  const double noise_share = maps_.noise_share(slipping), map_pa2 = map_pa * map_pa * noise_share;
  trial.noise_pa2 = std::max(shear_pa2 + map_pa2, std::numeric_limits<double>::min());
  trial.map_share = map_pa2 / trial.noise_pa2;
  const auto taxels = static_cast<double>(maps_.contact().size());
  // Of the maps as they are, with their noise.
  const double noisy_pa2 = square_pa2 + taxels * patch.noise_normal_pa * patch.noise_normal_pa * noise_share;
  trial.residual_pa2 =
      std::max(0.0, shear_square_pa2 - 2 * friction * product_pa2 + friction * friction * noisy_pa2);
  trial.misfit = 0.5 * (trial.residual_pa2 / trial.noise_pa2 + taxels * std::log(trial.noise_pa2));
  trials_.weigh_friction(measured, square_pa2, trial);
  return trial;
}

bool PressureMaps::superpose(const ContactPatch& patch, const RecordedMaps::PerMap& products,
                             double shear_square_pa2, JaegerDecomposition& out) const noexcept {
  const double floor_pa2 = std::numeric_limits<double>::min();
  JaegerDecomposition::Read sums{
      .products = {},
      .noise_shares = {},
      .sensed = {},
      .shear_pa2 = shear_square_pa2,
      .values = static_cast<double>(maps_.contact().size()),
      .noise_pa2 = std::max(patch.noise_shear_pa * patch.noise_shear_pa, floor_pa2),
      .map_noise_pa2 = patch.noise_normal_pa * patch.noise_normal_pa};
  std::array<RecordedMaps::Sum, JaegerDecomposition::kTerms> terms;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i] = maps_.at(JaegerDecomposition::share_of(i) * patch.normal_n);
    for (std::size_t k = 0; k < RecordedMaps::Sum::kTerms; ++k)
      out.add(i, maps_.force_n(terms[i].map[k]), terms[i].weight[k]);
    const auto row = static_cast<Eigen::Index>(i);
    sums.sensed[row] = RecordedMaps::product(terms[i], products);
    for (std::size_t j = 0; j <= i; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      sums.noise_shares(row, column) = sums.noise_shares(column, row) = maps_.noise_share(terms[i], terms[j]);
      sums.products(row, column) = sums.products(column, row) = maps_.product_pa2(terms[i], terms[j], 0);
    }
  }
  return out.solve(sums);
}

PressureMaps::Shear PressureMaps::read_shear(const ContactPatch& patch) noexcept {
  Shear shear;
  for (const std::uint32_t i : maps_.contact()) {
    shear_pa_[i] = static_cast<float>(patch.shear_along_pa(i));
    shear.along_pa2 += static_cast<double>(shear_pa_[i]) * shear_pa_[i];
    const double across_pa =
        patch.direction_x * patch.taxels.shear_y_pa[i] - patch.direction_y * patch.taxels.shear_x_pa[i];
    shear.across_pa2 += across_pa * across_pa;
  }
  const double noise_pa2 = patch.noise_shear_pa * patch.noise_shear_pa;
  shear.across_pa2 =
      std::max(0.0, shear.across_pa2 - static_cast<double>(maps_.contact().size()) * noise_pa2);
  return shear;
}

Reading PressureMaps::estimate(const Frame&, const ContactPatch& patch) noexcept {
  Reading out;
  if (!recorded(patch.normal_n)) return out;
  maps_.find_contact(patch.noise_normal_pa);
  const RecordedMaps::Sum today = maps_.at(patch.normal_n);
  if (!unmoved(patch, today)) return out;
  const Shear shear = read_shear(patch);
  const auto taxels = static_cast<double>(maps_.contact().size());
  const double deviation = std::sqrt(2 * taxels);  // of a sum of so many squares, over one
  const RecordedMaps::PerMap products = maps_.products(shear_pa_);
  if (JaegerDecomposition sum(patch.normal_n); superpose(patch, products, shear.along_pa2, sum)) {
    const double noise_pa2 = patch.noise_shear_pa * patch.noise_shear_pa;
    const ShearSquares squares{.excess_pa2 = sum.excess_pa2() + shear.across_pa2,
                               .noise_pa2 = noise_pa2 * deviation,
                               .explained_pa2 = shear.along_pa2 - taxels * noise_pa2 - sum.excess_pa2()};
    if (squares.unexplained_share() <= kMostUnexplained) sum.give_moments(out);
  }
  for (std::size_t i = 0; i < MarginTrials::kSteps; ++i)
    trials_[i] = judge(MarginTrials::gamma_of(i), patch, today, products, shear.along_pa2);
  const std::optional<std::size_t> step = trials_.best();
  if (!step) return out;
  const MarginTrial& best = trials_[*step];
  const ShearSquares squares{.excess_pa2 = best.residual_pa2 - best.noise_pa2 * taxels + shear.across_pa2,
                             .noise_pa2 = best.noise_pa2 * deviation,
                             .explained_pa2 = shear.along_pa2 - best.residual_pa2};
  const double unexplained = squares.unexplained_share();
  if (unexplained > kMostUnexplained) return out;
  trials_.weigh(out);
  if (out.sigma > kOpenSigma) trials_.give_profile(out);
  conclude(patch, best, unexplained, out);
  return out;
}

}  // namespace slipd
