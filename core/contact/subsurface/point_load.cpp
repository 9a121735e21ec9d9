#include "core/contact/subsurface/point_load.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace slipd::contact {
namespace {

// A function whose mixed derivative by x and y is what a point reads.
SensedTensor corner(double x, double y, double z) noexcept {
  const double xx = x * x, yy = y * y, zz = z * z, squares = xx + yy + zz, r = std::sqrt(squares);
  const double turn = std::atan(x * y / (z * r));
  constexpr double kShare = 1 / (2 * std::numbers::pi);
  return {.nn = kShare * (turn + z * x * y * (squares + zz) / (r * (xx + zz) * (yy + zz))),
          .nx = -kShare * zz * y / ((xx + zz) * r),
          .ny = -kShare * zz * x / ((yy + zz) * r),
          .xx = kShare * (turn - z * x * y / ((xx + zz) * r)),
          .xy = kShare * z / r,
          .yy = kShare * (turn - z * x * y / ((yy + zz) * r))};
}

}  // namespace

SensedTensor sensed_in_rectangle(const Rectangle& rectangle, double depth_m) noexcept {
  SensedTensor sum;
  const auto add = [&](double sign, double x_m, double y_m) {
    const SensedTensor at = corner(x_m, y_m, depth_m);
    sum.nn += sign * at.nn;
    sum.nx += sign * at.nx;
    sum.ny += sign * at.ny;
    sum.xx += sign * at.xx;
    sum.xy += sign * at.xy;
    sum.yy += sign * at.yy;
  };
  add(1, rectangle.right_m, rectangle.top_m);
  add(-1, rectangle.left_m, rectangle.top_m);
  add(-1, rectangle.right_m, rectangle.bottom_m);
  add(1, rectangle.left_m, rectangle.bottom_m);
  return sum;
}

LayerTensor sensed_in_rectangle(const Rectangle& rectangle, double depth_m,
                                std::span<const LayerImage> images) noexcept {
  if (images.empty()) {
    const SensedTensor of = sensed_in_rectangle(rectangle, depth_m);
    return {of.nn, of.nx, of.ny, of.xx, of.xy, of.yy, of.nx, of.ny};
  }
  std::array<double, 8> sum{};
  for (const LayerImage& image : images) {
    const SensedTensor of = sensed_in_rectangle(rectangle, image.depth * depth_m);
    const std::array<double, 6> from{of.nn, of.nx, of.ny, of.xx, of.xy, of.yy};
    add_image(image, from.data(), sum.data(), 1);
  }
  return {sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7]};
}

}  // namespace slipd::contact
