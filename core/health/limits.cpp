#include "core/health/limits.hpp"

namespace slipd {
namespace {

constexpr double kArrayFullScalePa = 20e6;
constexpr double kWrenchFullScaleN = 5000;

}  // namespace

FullScale default_full_scale(SensorClass sensor_class, const TaxelLayout& layout) noexcept {
  const double most_pa = sensor_class == SensorClass::wrench || layout.size() == 1
                             ? kWrenchFullScaleN / layout.area_m2()
                             : kArrayFullScalePa;
  return {most_pa, most_pa, most_pa};
}

}  // namespace slipd
