#include "core/plausibility/limits.hpp"

namespace slipd {
namespace {

constexpr double kArrayFullScale_pa = 20e6;
constexpr double kWrenchFullScale_n = 5000;

}  // namespace

FullScale default_full_scale(SensorClass sensor_class, const TaxelLayout& layout) noexcept {
  const double most_pa = sensor_class == SensorClass::wrench || layout.size() == 1
                             ? kWrenchFullScale_n / layout.area_m2()
                             : kArrayFullScale_pa;
  return {most_pa, most_pa, most_pa};
}

}  // namespace slipd
