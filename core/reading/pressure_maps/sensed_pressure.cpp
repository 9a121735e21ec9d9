// Of SensedMaps: the pressure that a pull is sensed as, told from other changes of the pressure.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/frame/significance.hpp"
#include "core/reading/pressure_maps/sensed_maps.hpp"
#include "core/reading/pressure_maps/taxel_sums.hpp"

namespace slipd {
namespace {

// Forces over the frame's whose maps stand for what any pull is sensed as; fewer: what is left of a pull
// passes for a change of the pressure.
constexpr std::array kPullShares{1.0, 0.5, 0.15};
// Taxels whose pressure changes alike where neither noise nor a pull nor a way explains it; 1 … 100. Too
// small: a pressure that creeps is taken for a pull. Too large: the pressure says nothing on real skins.
constexpr double kAlikeTaxels = 30;

}  // namespace

// pressure_pa_ is today's map.
void SensedMaps::find_ways() noexcept {
  const std::span<float> along_x = std::span(ways_).first(taxels_),
                         along_y = std::span(ways_).subspan(taxels_, taxels_),
                         grown = std::span(ways_).last(taxels_);
  std::copy(pressure_pa_.begin(), pressure_pa_.end(), grown.begin());
  std::fill(along_x.begin(), along_x.end(), 0.0F);
  std::fill(along_y.begin(), along_y.end(), 0.0F);
  for (std::size_t row = 0; row < rows_; ++row) {
    for (std::size_t i = row * columns_ + 1; i + 1 < (row + 1) * columns_; ++i)
      along_x[i] = pressure_pa_[i + 1] - pressure_pa_[i - 1];
  }
  for (std::size_t i = columns_; i + columns_ < taxels_; ++i)
    along_y[i] = pressure_pa_[i + columns_] - pressure_pa_[i - columns_];
  for (std::size_t way = 0; way < kWays; ++way) {
    TaxelVector now = taxel_vector(std::span(ways_).subspan(way * taxels_, taxels_));
    for (std::size_t other = 0; other < way; ++other) {
      const ConstTaxelVector before =
          taxel_vector(std::span<const float>(ways_).subspan(other * taxels_, taxels_));
      now -= now.dot(before) * before;
    }
    const float length = now.norm();
    if (length > 0) now /= length;
  }
}

void SensedMaps::without_ways(std::span<float> pressure) const noexcept {
  for (std::size_t way = 0; way < kWays; ++way) {
    const ConstTaxelVector known = taxel_vector(std::span(ways_).subspan(way * taxels_, taxels_));
    taxel_vector(pressure) -= taxel_vector(pressure).dot(known) * known;
  }
}

// A pull is sensed as pressure by the kernel that pressing is sensed as shear by.
void SensedMaps::weigh_pressure(const RecordedMaps& maps, double normal_n) noexcept {
  const std::span<float> pressure = std::span(read_pa_).last(taxels_);
  std::copy(pressure_pa_.begin(), pressure_pa_.end(), pressure.begin());
  without_ways(pressure);
  pulls_ = sensed_as_pressure_;
  Weights of_x = Weights::Zero(roots_.size()), of_y = of_x;
  std::array<Weights, kWays> ways_x, ways_y;
  ways_x.fill(of_x);
  ways_y.fill(of_x);
  for (std::size_t map = 0; map < maps.size(); ++map) {
    const auto i = static_cast<Eigen::Index>(map);
    const std::span<const float> x = sensed_of(maps.slot(map), false).last(taxels_),
                                 y = sensed_of(maps.slot(map), true).last(taxels_);
    of_x[i] = taxel_dot(pressure, x);
    of_y[i] = taxel_dot(pressure, y);
    for (std::size_t way = 0; way < kWays; ++way) {
      const std::span<const float> known = std::span(ways_).subspan(way * taxels_, taxels_);
      ways_x[way][i] = taxel_dot(known, x);
      ways_y[way][i] = taxel_dot(known, y);
    }
  }
  for (std::size_t way = 0; way < kWays; ++way) {
    pulls_.xx -= ways_x[way].lazyProduct(ways_x[way].transpose());
    pulls_.yy -= ways_y[way].lazyProduct(ways_y[way].transpose());
    const Square mixed = ways_x[way].lazyProduct(ways_y[way].transpose());
    pulls_.xy -= 0.5 * (mixed + mixed.transpose());
  }
  const double taxels = static_cast<double>(taxels_), square_pa2 = taxel_dot(pressure, pressure);
  const double noise_pa2 =
      std::max(frame_.normal_pa2 * (1 + noise_share(today_)), std::numeric_limits<double>::min());
  const double left_pa2 =
      std::max(0.0, square_pa2 - explained_pa2(maps, of_x, of_y, normal_n)) / std::max(1.0, taxels - kWays);
  // That no noise explains: the deviation of a mean square, and that of the noise as it is measured.
  const double surely = 1 + kClearSigmas * std::sqrt(2 * kOfMeasuredNoise / taxels);
  frame_.pressure_weight =
      pulled_ ? 0
              : frame_.shear_pa2 / (noise_pa2 + kAlikeTaxels * std::max(0.0, left_pa2 - surely * noise_pa2));
  taxel_vector(pressure) *= static_cast<float>(frame_.pressure_weight);
  const std::span<const float> shear = std::span<const float>(read_pa_).first(2 * taxels_);
  frame_.shear_square_pa2 = taxel_dot(shear, shear);
  frame_.square_pa2 = frame_.shear_square_pa2 + frame_.pressure_weight * square_pa2;
  frame_.values = taxels * (2 + std::min(1.0, frame_.pressure_weight * noise_pa2 / frame_.shear_pa2));
  pulls_.xx = sensed_as_shear_.xx + frame_.pressure_weight * pulls_.xx;
  pulls_.xy = sensed_as_shear_.xy + frame_.pressure_weight * pulls_.xy;
  pulls_.yy = sensed_as_shear_.yy + frame_.pressure_weight * pulls_.yy;
}

// By least squares over the maps of a few forces, pulled along x and along y.
double SensedMaps::explained_pa2(const RecordedMaps& maps, const Weights& of_x, const Weights& of_y,
                                 double normal_n) const noexcept {
  constexpr int kMaps = static_cast<int>(kPullShares.size());
  std::array<Weights, kPullShares.size()> of;
  for (std::size_t i = 0; i < of.size(); ++i) of[i] = at(maps, kPullShares[i] * normal_n);
  Eigen::Matrix<double, 2 * kMaps, 2 * kMaps> squares;
  Eigen::Matrix<double, 2 * kMaps, 1> sensed;
  for (int i = 0; i < kMaps; ++i) {
    const Weights& one = of[static_cast<std::size_t>(i)];
    sensed[i] = one.dot(of_x);
    sensed[kMaps + i] = one.dot(of_y);
    for (int j = 0; j < kMaps; ++j) {
      const Weights& other = of[static_cast<std::size_t>(j)];
      squares(i, j) = product(pulls_.xx, one, other);
      squares(i, kMaps + j) = squares(kMaps + j, i) = product(pulls_.xy, one, other);
      squares(kMaps + i, kMaps + j) = product(pulls_.yy, one, other);
    }
  }
  const Eigen::LDLT<Eigen::Matrix<double, 2 * kMaps, 2 * kMaps>> solved(squares);
  return solved.info() == Eigen::Success && solved.isPositive()
             ? std::max(0.0, sensed.dot(solved.solve(sensed)))
             : 0;
}

}  // namespace slipd
