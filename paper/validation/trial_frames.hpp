// Frames of contacts that are known, with noise: what methods are measured on. Set-up threads and tools.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/contact_field.hpp"
#include "core/contact/history.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/numeric/random.hpp"

namespace slipd {

// The noise of docs/methods.md §26.1 (p on p, q on q, as fractions of each one's maximum) or what hardware
// does (of the largest p on all three channels).
enum class NoiseKind : std::uint8_t { relative, sensor };

class TrialFrames {
 public:
  // noise: half-width of uniform noise as a fraction.
  TrialFrames(const TaxelLayout& layout, NoiseKind kind, double noise);

  // Exact averages of the contact over each taxel. One taxel alone is one force vector for the whole pad.
  void sense(const contact::LoadHistory& contact, double center_x_m, double center_y_m);

  // The same of a contact of any shape or under a skin, with its pull along direction_rad, from x to y.
  // Returns what is sensed of it, with noise; of this half-width on all channels, Pa, if it is given.
  Frame sense_field(contact::ContactField& geometry, const contact::LoadHistory& contact, double center_x_m,
                    double center_y_m, double direction_rad, const RandomStream& random,
                    std::optional<double> noise_pa = std::nullopt);

  // What was sensed, Pa: pressure, and shear along one direction. May be changed before it is sensed.
  std::span<float> normal_pa() noexcept { return normal_; }
  std::span<float> shear_pa() noexcept { return shear_; }
  std::span<const float> normal_pa() const noexcept { return normal_; }
  std::span<const float> shear_pa() const noexcept { return shear_; }

  // With noise, of a contact whose shear has no direction of its own: the caller wrote what is sensed into
  // normal_pa(), sensed_shear_x_pa() and sensed_shear_y_pa(). noise_pa as above. Valid until the next call.
  Frame sense_plane(const RandomStream& random, std::optional<double> noise_pa = std::nullopt);

  // With noise, the shear turned into a direction of the plane. The frame is valid until the next call.
  Frame sense(double direction_rad, const RandomStream& random, std::uint64_t sequence = 1,
              std::int64_t time_ns = 1);

  // Of the frame that was sensed last; for what a sensor does after its noise (dead taxels).
  std::span<float> sensed_normal_pa() noexcept { return noisy_; }
  std::span<float> sensed_shear_x_pa() noexcept { return x_; }
  std::span<float> sensed_shear_y_pa() noexcept { return y_; }

 private:
  const TaxelLayout& layout_;
  NoiseKind kind_;
  float noise_;
  std::vector<float> normal_, shear_, noisy_, x_, y_;
};

}  // namespace slipd
