#include "tools/sliplab/skin/shear_order.hpp"

#include <cmath>
#include <cstddef>

namespace sliplab {
namespace {

using namespace slipd;

// Standard deviations from which on a correlation is more than noise; 3 … 10. Too small: noise is advised on.
// Too large: light presses show nothing.
constexpr double kClear = 5;

enum Pair : std::uint8_t { xx, xy, yx, yy };

}  // namespace

std::string_view advice_on(ShearOrderVerdict verdict) noexcept {
  switch (verdict) {
    case ShearOrderVerdict::unclear:
    case ShearOrderVerdict::outward:
      return {};
    case ShearOrderVerdict::x_reversed:
      return "shear along x points inwards under a press: its sign is wrong";
    case ShearOrderVerdict::y_reversed:
      return "shear along y points inwards under a press: its sign is wrong";
    case ShearOrderVerdict::both_reversed:
      return "shear points inwards under a press: the signs of both its components are wrong";
    case ShearOrderVerdict::transposed:
      return "shear along x changes with the place along y under a press: x and y are exchanged, in the "
             "shear "
             "or in the layout (columns for rows)";
    case ShearOrderVerdict::turned:
      return "shear is turned by a quarter against the layout: x and y are exchanged, and one of them has "
             "the "
             "wrong sign";
  }
  return {};
}

void ShearOrder::add(const TaxelLayout& layout, const ContactPatch& patch) {
  if (!(patch.peak_pa > 0)) return;
  double all = 0, middle_x = 0, middle_y = 0;
  patch.for_each_inside([&](std::uint32_t i) {
    const double p = patch.taxels.normal_pa[i];
    all += p;
    middle_x += p * layout.x_m()[i];
    middle_y += p * layout.y_m()[i];
  });
  if (!(all > 0)) return;
  middle_x /= all;
  middle_y /= all;
  const double noise = patch.noise_shear_pa / patch.peak_pa;
  patch.for_each_inside([&](std::uint32_t i) {
    const double p = patch.taxels.normal_pa[i] / patch.peak_pa;
    const double x = (layout.x_m()[i] - middle_x) / patch.radius_m,
                 y = (layout.y_m()[i] - middle_y) / patch.radius_m;
    // Less what a pull lays on this taxel, about as much as its share of the pressure.
    const double share = patch.taxels.normal_pa[i] / patch.normal_n;
    const double qx = (patch.taxels.shear_x_pa[i] - patch.shear_x_n * share) / patch.peak_pa,
                 qy = (patch.taxels.shear_y_pa[i] - patch.shear_y_n * share) / patch.peak_pa;
    products_[xx] += p * qx * x;
    products_[xy] += p * qx * y;
    products_[yx] += p * qy * x;
    products_[yy] += p * qy * y;
    noise_[xx] += p * p * noise * noise * x * x;
    noise_[xy] += p * p * noise * noise * y * y;
    noise_[yx] += p * p * noise * noise * x * x;
    noise_[yy] += p * p * noise * noise * y * y;
    shear_square_ += std::fabs(p) * (qx * qx + qy * qy) / 2;
    place_square_ += std::fabs(p) * (x * x + y * y) / 2;
  });
}

std::array<double, 4> ShearOrder::correlations() const noexcept {
  const double scale = std::sqrt(shear_square_ * place_square_);
  std::array<double, 4> out{};
  if (!(scale > 0)) return out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = products_[i] / scale;
  return out;
}

ShearOrderVerdict ShearOrder::verdict() const noexcept {
  const auto clear = [&](Pair which) {
    return std::fabs(products_[which]) > kClear * std::sqrt(noise_[which]);
  };
  const double straight = std::fabs(products_[xx]) + std::fabs(products_[yy]),
               crossed = std::fabs(products_[xy]) + std::fabs(products_[yx]);
  if (straight >= crossed) {
    if (!clear(xx) || !clear(yy)) return ShearOrderVerdict::unclear;
    if (products_[xx] > 0)
      return products_[yy] > 0 ? ShearOrderVerdict::outward : ShearOrderVerdict::y_reversed;
    return products_[yy] > 0 ? ShearOrderVerdict::x_reversed : ShearOrderVerdict::both_reversed;
  }
  if (!clear(xy) || !clear(yx)) return ShearOrderVerdict::unclear;
  return products_[xy] * products_[yx] > 0 ? ShearOrderVerdict::transposed : ShearOrderVerdict::turned;
}

}  // namespace sliplab
