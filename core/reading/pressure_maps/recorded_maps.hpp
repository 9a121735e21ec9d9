// Maps of one contact, recorded while the gripper closed: the pressure on each taxel as a function of the
// normal force, and under a skin the shear that pressing alone is sensed as. Frames of nearly the same force
// are averaged, so that a map has less noise than a frame. Estimate thread; nothing allocates after
// construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/patch/disc_kernels.hpp"

namespace slipd {

// Two patterns are of one contact, or of one history, up to this 1 - cos^2 between them, beyond noise; 0.001
// … 0.05. Too small: real skins that creep get no margin, and noise is taken for a history. Too large: a
// contact that has moved or rolled gets one, and no other history is seen.
inline constexpr double kUnlike = 0.01;

// The greatest share of the shear that is clearly not explained, or that no depth explains of what pressing
// is sensed as: square root of the ratio of the sums of squares, 0.05 … 0.5. Too small: real contacts are
// refused, and real skins never show their depth. Too large: another load history passes, and a skin of
// another kind is taken for one of another depth.
inline constexpr double kMostUnexplained = 0.2;

class RecordedMaps {
 public:
  // The most maps that are kept.
  static constexpr std::size_t kMaps = 32;
  using PerMap = std::array<double, kMaps>;
  enum Channel : std::uint8_t { normal, shear_x, shear_y };

  // A weighted sum of a few maps; a weight of 0 for those that are not in it.
  struct Sum {
    static constexpr std::size_t kOfOneForce = 4;
    static constexpr std::size_t kTerms = 2 * kOfOneForce;
    std::array<std::size_t, kTerms> map{};
    std::array<double, kTerms> weight{};
  };

  // taxels: of each frame, > 0. with_shear: whether its shear is recorded as well.
  explicit RecordedMaps(std::size_t taxels, bool with_shear = false);

  // Beside the object itself.
  std::size_t memory_bytes() const noexcept {
    return sizeof(float) * values_.size() + sizeof(std::uint32_t) * contact_.capacity() +
           sizeof(std::size_t) * order_.capacity();
  }

  // Another contact: no maps.
  void clear() noexcept;

  // Where the mean is kept that a frame of this force would be added to; kMaps: a new one, beyond the others.
  std::size_t slot_of(double normal_n) const noexcept;
  // Frames in it.
  double frames_like(double normal_n) const noexcept;
  // Adds a frame. taxels: of the maps' number. normal_n: the resultant of their pressure, N, > 0.
  void add(const TaxelView& taxels, double normal_n) noexcept;

  // Maps, in order of their forces.
  std::size_t size() const noexcept { return order_.size(); }
  // The mean force of a map, N; rising with `map`, which is below size().
  double force_n(std::size_t map) const noexcept { return maps_[order_[map]].force_n; }
  // Frames in its mean.
  double frames(std::size_t map) const noexcept { return maps_[order_[map]].frames; }
  // Where the map is kept, below kMaps, and a number that no other content of it has had; the newest of them.
  std::size_t slot(std::size_t map) const noexcept { return order_[map]; }
  std::uint64_t version(std::size_t map) const noexcept { return maps_[order_[map]].version; }
  std::uint64_t newest() const noexcept { return versions_; }
  // The mean of one channel over its frames; shear only if it is recorded.
  std::span<const float> values(std::size_t map, Channel channel) const noexcept {
    return channel_of(order_[map], channel);
  }

  // The map of a force: on the parabola over its square root that fits the four nearest best, no pressure
  // under no force being one of them; far above the last force, of the last two as they go on.
  // normal_n >= 0, size() >= 3.
  Sum at(double normal_n) const noexcept;
  // a - b.
  static Sum difference(const Sum& a, const Sum& b) noexcept;

  // The taxels that sums are over: those that the last map presses clearly more than noise. The others have
  // nothing but noise, which would count. To be called after add() and before sums. noise_pa: as below.
  void find_contact(double noise_pa) noexcept;
  std::span<const std::uint32_t> contact() const noexcept { return contact_; }
  // Sums over the contact of a map's pressure by each taxel's value; for maps below size().
  PerMap products(std::span<const float> values) const noexcept;
  // The same of a sum of maps, from what products() gave.
  static double product(const Sum& sum, const PerMap& products) noexcept;
  // The sum over the contact of the products of two sums of maps, Pa^2, less what noise adds to it.
  // noise_pa: standard deviation of one taxel in one frame.
  double product_pa2(const Sum& a, const Sum& b, double noise_pa) const noexcept;
  double square_pa2(const Sum& sum, double noise_pa) const noexcept {
    return product_pa2(sum, sum, noise_pa);
  }
  // Covariance of one taxel of two sums of maps, over the variance of a frame's; variance of one sum.
  double noise_share(const Sum& a, const Sum& b) const noexcept;
  double noise_share(const Sum& sum) const noexcept { return noise_share(sum, sum); }

 private:
  struct Map {
    double frames = 0;  // 0: there is none
    double force_n = 0;
    std::uint64_t version = 0;
  };

  // All channels, one after the other.
  std::span<float> values_of(std::size_t slot) noexcept {
    return std::span(values_).subspan(slot * channels_ * taxels_, channels_ * taxels_);
  }
  std::span<const float> values_of(std::size_t slot) const noexcept {
    return std::span(values_).subspan(slot * channels_ * taxels_, channels_ * taxels_);
  }
  std::span<const float> channel_of(std::size_t slot, Channel channel) const noexcept {
    return values_of(slot).subspan(channel * taxels_, taxels_);
  }
  std::span<const float> normal_of(std::size_t slot) const noexcept { return channel_of(slot, normal); }
  double product(std::span<const float> a, std::span<const float> b) const noexcept;
  void halve() noexcept;
  void join(std::size_t into, std::size_t first, std::size_t second) noexcept;
  void sort_out() noexcept;

  const std::size_t taxels_, channels_;
  std::uint64_t versions_ = 0;
  std::vector<std::uint32_t> contact_;  // none: not known since the last frame was added
  std::vector<float> values_;           // kMaps maps, one after the other
  // By slot: of forces whose square root is between slot and slot + 1 times root_step_.
  std::array<Map, kMaps> maps_;
  std::array<PerMap, kMaps> products_{};  // of the maps of two slots over the contact, Pa^2
  double root_step_ = 0;                  // sqrt(N); 0: no map yet
  std::vector<std::size_t> order_;        // slots that have a map
};

}  // namespace slipd
