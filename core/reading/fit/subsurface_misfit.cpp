// What a SubsurfaceFit leaves over that noise does not explain: of another shape, and of another history.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/frame/model_errors.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/fit/residual_sums.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

double SubsurfaceFit::residual_pressure(const Full& at) const noexcept {
  const double noise_pa = model_.noise().normal_pa;
  const auto left = model_.residuals(), u = model_.u(), v = model_.v();
  ResidualParts parts(at[ContactShape::size]);
  for (std::size_t i = 0; i < model_.count(); ++i) parts.add(u[i], v[i], noise_pa * left[i]);
  return parts.beyond_noise_pa(noise_pa, frame_.elliptic ? 6 : 4) / at[ContactShape::peak];
}

double SubsurfaceFit::ring_misfit(const Full& at, std::span<const double> held) const noexcept {
  const contact::Ellipse ellipse = ContactShape::ellipse_of(at, 1);
  const double c = std::cos(ellipse.angle_rad), s = std::sin(ellipse.angle_rad);
  const double pull_x = std::cos(at[ContactShape::direction]), pull_y = std::sin(at[ContactShape::direction]);
  const double limit_pa = at[ContactShape::peak] * at[ContactShape::load] / (1 - at[ContactShape::margin]);
  const ContactShape::Noise& noise = model_.noise();
  const std::size_t n = model_.count();
  const auto left = model_.residuals(), u = model_.u(), v = model_.v();
  ResidualRings rings;
  for (std::size_t i = 0; i < n; ++i) {
    const double along_a = (c * u[i] + s * v[i]) / ellipse.a_m, along_b = (c * v[i] - s * u[i]) / ellipse.b_m;
    rings.add(norm(along_a, along_b), noise.shear_pa * (pull_x * left[n + i] + pull_y * left[2 * n + i]),
              limit_pa * held[i]);
  }
  // What is left of the shear is noise and misfit: noise is hardly more than that of the pressure.
  constexpr double kMostNoise = 1.5;
  return rings.misfit(std::min(noise.shear_pa, kMostNoise * noise.normal_pa), kUnevenShare);
}

}  // namespace slipd
