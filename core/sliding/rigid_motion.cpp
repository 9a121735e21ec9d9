#include "core/sliding/rigid_motion.hpp"

#include <cmath>
#include <cstddef>

#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kMmPerM = 1e3;
constexpr std::size_t kLeastPoints = 3;

}  // namespace

double RigidMotion::along_mm() const noexcept {
  return norm(x_mm, y_mm);
}

RigidMotion rigid_motion(const TaxelLayout& layout, std::span<const float> change_x_mm,
                         std::span<const float> change_y_mm) noexcept {
  double n = 0, x = 0, y = 0, ux = 0, uy = 0, xx = 0, turn = 0, uu = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double vx = static_cast<double>(change_x_mm[i]), vy = static_cast<double>(change_y_mm[i]);
    if (!std::isfinite(vx) || !std::isfinite(vy)) continue;
    const double px = kMmPerM * layout.x_m()[i], py = kMmPerM * layout.y_m()[i];
    n += 1;
    x += px;
    y += py;
    ux += vx;
    uy += vy;
    xx += px * px + py * py;
    turn += px * vy - py * vx;
    uu += vx * vx + vy * vy;
  }
  if (n < static_cast<double>(kLeastPoints)) return {};
  RigidMotion motion{.x_mm = ux / n, .y_mm = uy / n};
  const double spread = xx - (x * x + y * y) / n;
  const double moment = turn - (x * uy - y * ux) / n;
  if (spread > 0) motion.turn_rad = moment / spread;
  motion.turning_mm = std::abs(motion.turn_rad) * std::sqrt(spread / n);
  const double rest = (uu - (ux * ux + uy * uy) / n - motion.turn_rad * moment) / n;
  motion.stretch_mm = std::sqrt(rest > 0 ? rest : 0);
  return motion;
}

}  // namespace slipd
