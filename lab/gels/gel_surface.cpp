#include "lab/gels/gel_surface.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace lab {
namespace {

// What lies in the plane of a wave is a sum of four solutions (Papkovich and Neuber), two that decay from the
// surface and two from the base. Their displacement along the wave (over i) and up, and its slopes.
struct Solutions {
  Eigen::RowVector4d along, up, along_slope, up_slope;
};

Solutions solutions(double k, double z, double thickness, double poisson) {
  const double turn = 3 - 4 * poisson, up = std::exp(k * z), down = std::exp(-k * (z + thickness));
  return {.along = {up, z * up, down, z * down},
          .up = {up, (z - turn / k) * up, -down, -(z + turn / k) * down},
          .along_slope = {k * up, (1 + k * z) * up, -k * down, (1 - k * z) * down},
          .up_slope = {k * up, (1 + k * z - turn) * up, k * down, (k * z - 1 + turn) * down}};
}

// Transform of the dome sqrt(1 - r^2/a^2), over 2 pi a^2.
double dome(double ka) noexcept {
  if (ka < 0.05) return 1.0 / 3 - ka * ka / 30;
  return (std::sin(ka) / ka - std::cos(ka)) / (ka * ka);
}

}  // namespace

GelSurface::Wave GelSurface::wave(double k, double poisson) const {
  const double lame = 2 * poisson / (1 - 2 * poisson);  // over the shear modulus
  const Solutions top = solutions(k, 0, thickness_m_, poisson),
                  base = solutions(k, -thickness_m_, thickness_m_, poisson);
  Eigen::Matrix4d system;
  system << top.along_slope + k * top.up, lame * (top.up_slope - k * top.along) + 2 * top.up_slope,
      base.along, base.up;
  const Eigen::PartialPivLU<Eigen::Matrix4d> solved(system);
  return {.along = top.along.dot(solved.solve(Eigen::Vector4d(1, 0, 0, 0))),
          .across = std::tanh(k * thickness_m_) / k,
          .pressed = top.along.dot(solved.solve(Eigen::Vector4d(0, -1, 0, 0)))};
}

GelSurface::GelSurface(double thickness_m, double poisson) : thickness_m_(thickness_m) {
  constexpr int kWaves = 1600;
  constexpr double kStep_per_m = 20;  // a quarter of a period over the largest distance
  for (int i = 0; i < kWaves; ++i) {
    const double k = kStep_per_m * (i + 0.5);
    const Wave moved = wave(k, poisson);
    std::array<double, kRadii> domes;
    for (int a = 0; a < kRadii; ++a) {
      const double radius = kRadiusStep_m * (a + 1);
      domes[static_cast<std::size_t>(a)] = radius * radius * dome(k * radius) * k * kStep_per_m;
    }
    for (std::size_t r = 0; r <= kDistances; ++r) {
      const double kr = k * kDistanceStep_m * static_cast<double>(r);
      const double even = 0.5 * (moved.along + moved.across) * std::cyl_bessel_j(0, kr);
      const double twofold = -0.5 * (moved.along - moved.across) * std::cyl_bessel_j(2, kr);
      const double radial = -moved.pressed * std::cyl_bessel_j(1, kr);
      for (std::size_t a = 0; a < kRadii; ++a) {
        table_[a][r].even += even * domes[a];
        table_[a][r].twofold += twofold * domes[a];
        table_[a][r].radial += radial * domes[a];
      }
    }
  }
}

// Linear between the table's places. A smaller disc moves the surface like the smallest, by its area.
GelSurface::Values GelSurface::at(double radius_m, double r_m) const noexcept {
  const double radii = std::clamp(radius_m / kRadiusStep_m - 1, 0.0, kRadii - 1.001);
  const double distances = std::clamp(r_m / kDistanceStep_m, 0.0, kDistances - 0.001);
  const auto a = static_cast<std::size_t>(radii), r = static_cast<std::size_t>(distances);
  const double more_a = radii - static_cast<double>(a), more_r = distances - static_cast<double>(r);
  const double area = std::min(1.0, std::pow(radius_m / kRadiusStep_m, 2));
  const auto between = [&](double Values::*value) {
    const auto along = [&](std::size_t row) {
      return (1 - more_r) * table_[row][r].*value + more_r * table_[row][r + 1].*value;
    };
    return area * ((1 - more_a) * along(a) + more_a * along(a + 1));
  };
  return {between(&Values::even), between(&Values::twofold), between(&Values::radial)};
}

GelSurface::Moved GelSurface::dragged(double radius_m, double x_m, double y_m) const noexcept {
  const Values moved = at(radius_m, std::hypot(x_m, y_m));
  const double twice = 2 * std::atan2(y_m, x_m);
  return {moved.even + moved.twofold * std::cos(twice), moved.twofold * std::sin(twice)};
}

double GelSurface::pressed(double radius_m, double r_m) const noexcept {
  return at(radius_m, r_m).radial;
}

}  // namespace lab
