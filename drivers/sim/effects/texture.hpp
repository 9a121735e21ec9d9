// The relief of an object's surface: a sum of plane waves of random direction, length and phase. It goes on
// without end, so that an object may slide any distance. A pure function of the place.
#pragma once

#include <array>
#include <cstdint>

namespace slipd::sim {

struct TextureSettings {
  // Root mean square of the height, m; 0: smooth.
  double rms_m = 0;
  // Wavelengths, m; 0 < shortest <= longest. Waves shorter than a taxel are averaged by it.
  double shortest_m = 0.006;
  double longest_m = 0.03;
};

class Texture {
 public:
  Texture(const TextureSettings& settings, std::uint64_t seed) noexcept;

  // Height at a place on the object, m, above 0 towards the sensor.
  double height_m(double x_m, double y_m) const noexcept;

 private:
  static constexpr std::size_t kWaves = 12;
  struct Wave {
    double kx = 0, ky = 0, phase_rad = 0;  // wave numbers, rad/m
  };
  double amplitude_m_;
  std::array<Wave, kWaves> waves_;
};

}  // namespace slipd::sim
