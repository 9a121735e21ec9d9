#include "drivers/sim/effects/realistic_sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/numeric/random.hpp"

namespace slipd::sim {
namespace {

enum EffectStream : std::uint64_t {
  shaking_stream,
  contact_stream,
  tilt_stream,
  skin_noise_stream,
  skin_drift_stream
};

// Elements of a skin along the side of a taxel, and their greatest number.
constexpr double kElementsPerSide = 3;
constexpr double kMostElementsPerAxis = 48;

struct Elements {
  std::vector<double> x_m, y_m;
  double area_m2 = 0;
};

std::uint64_t seed_of(std::uint64_t seed, EffectStream effect) {
  return RandomStream(seed ^ 0x7265616cULL).stream(effect).bits(0);
}

Elements taxels_themselves(const TaxelLayout& layout) {
  return {{layout.x_m().begin(), layout.x_m().end()},
          {layout.y_m().begin(), layout.y_m().end()},
          layout.area_m2()};
}

// A square grid over all taxels.
Elements of_skin(const TaxelLayout& layout) {
  const auto extent = [&](std::span<const double> at_m) {
    const auto [low, high] = std::minmax_element(at_m.begin(), at_m.end());
    return std::pair(*low - layout.side_m() / 2, *high + layout.side_m() / 2);
  };
  const auto [left, right] = extent(layout.x_m());
  const auto [bottom, top] = extent(layout.y_m());
  const double step = std::max({layout.side_m() / kElementsPerSide, (right - left) / kMostElementsPerAxis,
                                (top - bottom) / kMostElementsPerAxis});
  const auto columns = std::llround((right - left) / step), rows = std::llround((top - bottom) / step);
  Elements elements{.x_m = {}, .y_m = {}, .area_m2 = step * step};
  for (long long row = 0; row < rows; ++row) {
    for (long long column = 0; column < columns; ++column) {
      elements.x_m.push_back(left + (static_cast<double>(column) + 0.5) * step);
      elements.y_m.push_back(bottom + (static_cast<double>(row) + 0.5) * step);
    }
  }
  return elements;
}

Elements elements_of(const EffectSettings& effects, const TaxelLayout& layout) {
  return effects.depth_m > 0 ? of_skin(layout) : taxels_themselves(layout);
}

RoughContact contact_of(const EffectSettings& effects, const Elements& elements, std::uint64_t seed) {
  return {effects.contact, elements.x_m, elements.y_m, elements.area_m2, seed_of(seed, contact_stream)};
}

}  // namespace

RealisticSensor::RealisticSensor(const EffectSettings& effects, const TaxelLayout& layout, std::uint64_t seed)
    : area_m2_(layout.area_m2()),
      rubber_(effects.grip),
      shaking_(effects.shaking, seed_of(seed, shaking_stream)),
      contact_(contact_of(effects, elements_of(effects, layout), seed)),
      tilt_(effects.tilt, layout, seed_of(seed, tilt_stream)),
      noise_(effects.noise, layout.size(), seed_of(seed, skin_noise_stream)),
      drift_(effects.drift, layout.size(), seed_of(seed, skin_drift_stream)),
      range_(effects.range) {
  if (effects.depth_m > 0) {
    const Elements elements = of_skin(layout);
    skin_.emplace(layout, elements.x_m, elements.y_m, effects.depth_m);
    skin_->calibrate(layout.area_m2());
  }
}

void RealisticSensor::update(const LoadTarget& target, std::int64_t time_ns) noexcept {
  const double dt_s = 1e-9 * static_cast<double>(time_ns - time_ns_),
               now_s = 1e-9 * static_cast<double>(time_ns);
  time_ns_ = time_ns;
  const double gripped_n = rubber_.update(target.normal_n, dt_s);
  const double normal_n = gripped_n * std::max(0.0, 1 + shaking_.normal(now_s));
  contact_.press(normal_n, target.friction);
  const double pulled_n = target.by_load ? target.shear * contact_.capacity_n() : target.shear;
  contact_.pull(pulled_n + shaking_.shear(now_s) * normal_n, dt_s);
}

void RealisticSensor::sense(FrameSlot& out, std::uint64_t number, std::int64_t time_ns) noexcept {
  if (skin_) {
    skin_->sense(contact_.normal_n(), contact_.shear_n(), out.normal_pa, out.shear_x_pa, out.shear_y_pa);
  } else {
    for (std::size_t i = 0; i < out.normal_pa.size(); ++i) {
      out.normal_pa[i] = static_cast<float>(contact_.normal_n()[i] / area_m2_);
      out.shear_x_pa[i] = static_cast<float>(contact_.shear_n()[i] / area_m2_);
      out.shear_y_pa[i] = 0;
    }
  }
  tilt_.apply(out.normal_pa, out.shear_x_pa, out.shear_y_pa);
  const std::array<std::span<float>, 3> channels{out.normal_pa, out.shear_x_pa, out.shear_y_pa};
  const double time_s = 1e-9 * static_cast<double>(time_ns);
  noise_.add(channels, number, time_s);
  drift_.add(channels, number, time_s);
}

void RealisticSensor::limit(FrameSlot& out) const noexcept {
  const auto within = [](std::span<float> values, double most_pa) {
    const auto most = static_cast<float>(most_pa);
    for (float& value : values) value = std::clamp(value, -most, most);
  };
  within(out.normal_pa, range_.normal_pa);
  within(out.shear_x_pa, range_.shear_pa);
  within(out.shear_y_pa, range_.shear_pa);
}

}  // namespace slipd::sim
