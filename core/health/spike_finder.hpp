// Single taxels that no neighbour supports: a bit that is stuck, a broken wire, a value that is not a number.
// An elastic skin spreads a force over its neighbours, the further the larger the force is, so that one taxel
// cannot carry much alone. Such taxels are replaced by the mean of their neighbours. Estimate thread; nothing
// allocates after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/health/limits.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

struct SpikeOptions {
  // A taxel stands alone if no neighbour reads more than this share of it; 0.05 … 0.6. Too small: spikes
  // beside a contact are believed. Too large: the middle of a small contact is called a spike: Hertz's of
  // kResolvedSides leaves 0.7 to a neighbour.
  double support_share = 0.4;
  // A peak is looked at if it is above the last frame's by this factor, and all taxels if the noise of single
  // shears off the contact is; 1.05 … 2. Too small: costs time. Too large: spikes little above the contact's
  // peak stay until the next look, and sigma is wide until then.
  double grown_factor = 1.25;
};

class SpikeFinder {
 public:
  SpikeFinder(const TaxelLayout& layout, const PlausibilityLimits& limits, const SpikeOptions& options = {});

  // Looks for spikes in the frame that `patch` is of. Returns how many are left out, or more than may_leave()
  // if there are too many to leave out: more than kBadTaxels.
  std::size_t find(const Frame& frame, const ContactPatch& patch) noexcept;

  std::size_t may_leave() const noexcept { return may_leave_; }

  // `frame` with the spikes that were found replaced; valid until the next call of find.
  Frame mended(const Frame& frame) const noexcept;

  // Force that the replaced taxels stand for, N.
  double left_out_n() const noexcept { return left_out_n_; }

 private:
  struct Neighbourhood {
    float greatest_normal_pa = 0, greatest_shear_pa = 0;
    std::array<float, 3> mean_pa{};
  };
  struct Values {
    std::span<const float> normal_pa, shear_x_pa, shear_y_pa;
  };
  // How closely this frame is looked at.
  enum class Look : std::uint8_t { none, at_peak, at_all };
  Look needed(const ContactPatch& patch) noexcept;
  // Whether the frame's greatest pressure or the contact's greatest shear stands alone; both are finite.
  bool peak_stands_alone(const Frame& frame, const ContactPatch& patch) const noexcept;
  std::size_t replace_all(const Frame& frame, const ContactPatch& patch) noexcept;
  void copy(const Frame& frame) noexcept;
  std::uint32_t worst_normal() const noexcept;
  std::uint32_t worst_shear() const noexcept;
  Values own() const noexcept { return {normal_, shear_x_, shear_y_}; }
  bool beyond(const Values& values, std::size_t taxel) const noexcept;
  bool spreads(double pressure_pa, double last_pa) const noexcept;
  bool alone(double normal_pa, const Neighbourhood& around) const noexcept;
  bool shear_alone(double shear_pa, double normal_pa, const Neighbourhood& around) const noexcept;
  Neighbourhood around(const Values& values, std::uint32_t taxel) const noexcept;
  void replace(std::uint32_t taxel, const Neighbourhood& around) noexcept;

  TaxelLayout layout_;
  PlausibilityLimits limits_;
  SpikeOptions options_;
  std::size_t may_leave_;
  std::vector<float> normal_, shear_x_, shear_y_;  // the mended frame
  double left_out_n_ = 0;
  float last_peak_pa_ = 0;  // of the last frame without its spikes
  float last_shear_pa_ = 0;
  double last_noise_pa_ = 0;  // of shear off the contact
  bool touched_ = false;      // the last frame was in contact
  bool found_ = false;        // the last frame had a spike
  std::uint32_t frames_ = 0;
};

}  // namespace slipd
