// What an SubsurfaceFit leaves over that noise does not explain: of another shape, and of another history.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// As Fit::residual_pressure, about the ellipse: part by part, where it lies clearly above noise.
double SubsurfaceFit::residual_pressure(const Full& at) const noexcept {
  struct Part {
    double off = 0, taxels = 0;
  };
  std::array<Part, 16> parts;
  const double half = 0.5 * at[ContactShape::size] * at[ContactShape::size],
               noise_pa = model_.noise().normal_pa;
  const auto left = model_.residuals(), all_u = model_.u(), all_v = model_.v();
  for (std::size_t i = 0; i < model_.count(); ++i) {
    const double u = all_u[i], v = all_v[i];
    Part& part = parts[(u > 0 ? 1U : 0U) + (v > 0 ? 2U : 0U) + (std::fabs(u) > std::fabs(v) ? 4U : 0U) +
                       (u * u + v * v > half ? 8U : 0U)];
    part.off += noise_pa * left[i];
    part.taxels += 1;
  }
  double squares = 0;
  for (const Part& part : parts) squares += part.taxels > 0 ? part.off * part.off / part.taxels : 0;
  const double fitted = frame_.elliptic ? 6 : 4, free = static_cast<double>(parts.size()) - fitted;
  const double by_noise = noise_pa * noise_pa;
  if (squares < (free + kClearSigmas * std::sqrt(2 * free)) * by_noise) return 0;
  return std::sqrt((squares - free * by_noise) / static_cast<double>(model_.count())) /
         at[ContactShape::peak];
}

// As Fit::ring_misfit: noise averages out in a ring, another history of the load does not.
double SubsurfaceFit::ring_misfit(const Full& at, std::span<const double> held) const noexcept {
  constexpr std::size_t kRings = 12;
  struct Ring {
    double off = 0, held = 0, taxels = 0;
  };
  std::array<Ring, kRings> rings;
  const contact::Ellipse ellipse = ContactShape::ellipse_of(at, 1);
  const double c = std::cos(ellipse.angle_rad), s = std::sin(ellipse.angle_rad);
  const double pull_x = std::cos(at[ContactShape::direction]), pull_y = std::sin(at[ContactShape::direction]);
  const double limit_pa = at[ContactShape::peak] * at[ContactShape::load] / (1 - at[ContactShape::margin]);
  const ContactShape::Noise& noise = model_.noise();
  const std::size_t n = model_.count();
  const auto left = model_.residuals(), u = model_.u(), v = model_.v();
  for (std::size_t i = 0; i < n; ++i) {
    const double along_a = (c * u[i] + s * v[i]) / ellipse.a_m, along_b = (c * v[i] - s * u[i]) / ellipse.b_m;
    const auto which = static_cast<std::size_t>(norm(along_a, along_b) * kRings);
    Ring& ring = rings[std::min(which, kRings - 1)];
    ring.off += noise.shear_pa * (pull_x * left[n + i] + pull_y * left[2 * n + i]);
    ring.held += limit_pa * held[i];
    ring.taxels += 1;
  }
  // What is left of the shear is noise and misfit: noise is hardly more than that of the pressure.
  constexpr double kMostNoise = 1.5;
  const double noise_pa = std::min(noise.shear_pa, kMostNoise * noise.normal_pa);
  double misfit = 0;
  int used = 0;
  for (const Ring& ring : rings) {
    if (ring.taxels < 1) continue;
    const double uneven = kUnevenShare * ring.held;
    misfit += ring.off * ring.off / (noise_pa * noise_pa * ring.taxels + uneven * uneven);
    ++used;
  }
  return used > 0 ? misfit / used : 0;
}

}  // namespace slipd
