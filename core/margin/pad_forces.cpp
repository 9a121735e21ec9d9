#include "core/margin/pad_forces.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

using contact::LayerTensor;
using contact::Rectangle;

// Of a pull along the axis of which less is read.
double read_of_pull(const LayerTensor& read) noexcept {
  return std::min(read.xx, read.yy);
}

// A regular grid is one part, other layouts have a square for each taxel.
std::vector<Rectangle> parts_of(const TaxelLayout& layout) {
  const double half_m = layout.side_m() / 2;
  const auto about = [half_m](double left, double right, double bottom, double top) {
    return Rectangle{left - half_m, right + half_m, bottom - half_m, top + half_m};
  };
  const auto x = layout.x_m(), y = layout.y_m();
  if (layout.regular()) return {about(x.front(), x.back(), y.front(), y.back())};
  std::vector<Rectangle> parts;
  parts.reserve(layout.size());
  for (std::size_t i = 0; i < layout.size(); ++i) parts.push_back(about(x[i], x[i], y[i], y[i]));
  return parts;
}

std::vector<contact::LayerImage> images_of(const Skin& skin) {
  const auto poisson = skin.bonded_poisson();
  if (!poisson) return {};
  const auto all = contact::layer_images(*poisson);
  return {all.begin(), all.end()};
}

}  // namespace

PadForces::PadForces(const TaxelLayout& layout, const Skin& skin, const PadForcesOptions& options)
    : options_(options),
      layout_(layout),
      depth_m_(skin.depth_m),
      images_(images_of(skin)),
      parts_(parts_of(layout)),
      ratio_sigma_(norm(kUnevenShare, missed_sigma(skin.depth_sigma))) {}

// What is missed grows with the depth. Loads lie on any taxel.
double PadForces::missed_sigma(double depth_sigma) const noexcept {
  double read = 0;
  for (std::size_t i = 0; i < layout_.size(); ++i)
    read +=
        read_of_pull(read_of(layout_.x_m()[i], layout_.y_m()[i], 0)) / static_cast<double>(layout_.size());
  read = std::clamp(read, options_.least_read, 1.0);
  return (1 - read) / read * depth_sigma;
}

// Four points about the middle have the load's second moments.
LayerTensor PadForces::read_of(double x_m, double y_m, double spread_m) const noexcept {
  constexpr double kPoints = 4;
  LayerTensor sum;
  const auto add_point = [&](double x, double y) {
    for (const Rectangle& part : parts_)
      sum = combined(
          1, sum, 1 / kPoints,
          contact::sensed_in_rectangle({part.left_m - x, part.right_m - x, part.bottom_m - y, part.top_m - y},
                                       depth_m_, images_));
  };
  add_point(x_m - spread_m, y_m);
  add_point(x_m + spread_m, y_m);
  add_point(x_m, y_m - spread_m);
  add_point(x_m, y_m + spread_m);
  return sum;
}

PadForces::Sums PadForces::sums_of(const ContactPatch& patch) const noexcept {
  Sums sums;
  const double clear_pa = kClearSigmas * patch.noise_normal_pa, area_m2 = layout_.area_m2();
  double weights = 0, x = 0, y = 0, xx = 0, yy = 0;
  for (std::size_t i = 0; i < layout_.size(); ++i) {
    const double p = patch.taxels.normal_pa[i];
    sums.normal_n += area_m2 * p;
    sums.shear_x_n += area_m2 * patch.taxels.shear_x_pa[i];
    sums.shear_y_n += area_m2 * patch.taxels.shear_y_pa[i];
    if (!(p > clear_pa)) continue;
    const double at_x = layout_.x_m()[i], at_y = layout_.y_m()[i];
    weights += p;
    x += p * at_x;
    y += p * at_y;
    xx += p * at_x * at_x;
    yy += p * at_y * at_y;
  }
  sums.pressed = weights > 0 && sums.normal_n > 0;
  if (!sums.pressed) return sums;
  sums.x_m = x / weights;
  sums.y_m = y / weights;
  sums.squares_m2 = (xx + yy) / weights - sums.x_m * sums.x_m - sums.y_m * sums.y_m;
  return sums;
}

std::optional<PadForces::Forces> PadForces::of(const ContactPatch& patch,
                                               const Reading& fitted) const noexcept {
  constexpr int kRounds = 2;  // the pressure that is read is drawn along the pull, by d Q/P
  const Sums sums = sums_of(patch);
  if (!sums.pressed) return std::nullopt;
  // A skin spreads pressure by d along each axis, taxels by their squares.
  const double side_m = layout_.side_m(),
               spread_m =
                   std::sqrt(std::max(0.0, sums.squares_m2 - 2 * depth_m_ * depth_m_ - side_m * side_m / 6));
  Eigen::Vector3d load(1, 0, 0);
  Eigen::Matrix3d of_load;
  double part = 0;
  for (int round = 0; round < kRounds; ++round) {
    const double drawn_m = depth_m_ / load[0];
    const LayerTensor read = read_of(sums.x_m - drawn_m * load[1], sums.y_m - drawn_m * load[2], spread_m);
    part = read_of_pull(read);
    if (!(part > options_.least_read) || !(read.nn > options_.least_read)) return std::nullopt;
    of_load << read.nn, read.nx, read.ny, read.xn, read.xx, read.xy, read.yn, read.xy, read.yy;
    load = of_load.inverse() * Eigen::Vector3d(sums.normal_n, sums.shear_x_n, sums.shear_y_n);
    if (!(load[0] > 0) || !load.allFinite()) return std::nullopt;
  }
  // Noise that taxels share is in the patch's deviations.
  const double area_m2 = layout_.area_m2() * std::sqrt(static_cast<double>(layout_.size()));
  const double normal_pa = std::max(patch.noise_normal_pa, fitted.noise_normal_pa),
               shear_pa = std::max(patch.noise_shear_pa, fitted.noise_shear_pa);
  return Forces{.normal_n = load[0],
                .shear_x_n = load[1],
                .shear_y_n = load[2],
                .normal_sigma_n = std::max(area_m2 * normal_pa, patch.normal_sigma_n) / of_load(0, 0),
                .shear_sigma_n = std::max(area_m2 * shear_pa, patch.shear_sigma_n) / part,
                .read = part};
}

}  // namespace slipd
