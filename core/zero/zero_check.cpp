#include "core/zero/zero_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/few_taxels.hpp"
#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"

namespace slipd {
namespace {

// Share of its load by which a skin relaxes or springs back, and no load has fallen: one that was held while
// the sensor was away may have changed by it, and a taxel is below its zero where it reads less by more than
// this share of the greatest pressure that it had.
const auto kRelaxedShare = static_cast<float>(1 - kFallen);

// `share` of the taxels, at least kBadTaxels, at most all.
std::size_t count_of(std::size_t taxels, double share) noexcept {
  const auto part = static_cast<std::size_t>(std::ceil(share * static_cast<double>(taxels)));
  return std::min(taxels, std::max<std::size_t>(part, kBadTaxels));
}

}  // namespace

ZeroCheck::ZeroCheck(std::size_t taxels, const ZeroCheckOptions& options)
    : taxels_(taxels), options_(options), pressed_pa_(taxels) {}

float ZeroCheck::tolerance_pa(const Bias& zero, std::size_t channel, const Floors& floors) const noexcept {
  const bool normal = channel < taxels_;
  const float noise =
      std::max(zero.noise_pa[channel], normal ? floors.noise_normal_pa : floors.noise_shear_pa);
  const float step = normal ? floors.step_normal_pa : floors.step_shear_pa;
  return static_cast<float>(kStrongSigmas) * std::max(noise, rounding_noise(step));
}

bool ZeroCheck::agrees(const Frame& reading, const Bias& zero, std::span<const float> last_pa,
                       const Floors& floors) const noexcept {
  const std::span<const float> channels[] = {reading.normal_pa, reading.shear_x_pa, reading.shear_y_pa};
  constexpr float kRounding = 1e-6F;  // of single precision
  std::size_t as_zero = 0, as_last = 0;
  for (std::size_t taxel = 0; taxel < taxels_; ++taxel) {
    bool like_zero = true, like_last = !last_pa.empty();
    for (std::size_t kind = 0; kind < std::size(channels); ++kind) {
      const std::size_t i = kind * taxels_ + taxel;
      const float now = channels[kind][taxel], free = zero.bias_pa[i];
      const float within = tolerance_pa(zero, i, floors) + kRounding * std::abs(now);
      like_zero = like_zero && std::abs(now - free) <= within;
      if (like_last) {
        const float load = std::abs(last_pa[i] - free);
        like_last = std::abs(now - last_pa[i]) <= within + kRelaxedShare * load;
      }
    }
    as_zero += like_zero ? 1 : 0;
    as_last += like_last ? 1 : 0;
  }
  const std::size_t needed = count_of(taxels_, options_.agree_share);
  return std::max(as_zero, as_last) >= needed && !is_below(reading, zero, floors);
}

bool ZeroCheck::is_below(const Frame& reading, const Bias& zero, const Floors& floors) const noexcept {
  std::size_t below = 0;
  double lifted_pa = 0, pressed_pa = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const float load = reading.normal_pa[i] - zero.bias_pa[i];
    const float far = tolerance_pa(zero, i, floors) + kRelaxedShare * pressed_pa_[i];
    if (load < -far) {
      ++below;
      lifted_pa -= load;
    } else if (load > far) {
      pressed_pa += load;
    }
  }
  if (below < count_of(taxels_, kBadShare)) return false;
  return lifted_pa > kBeyondUsual * pressed_pa || 2 * below > taxels_;
}

void ZeroCheck::note_pressed(std::span<const float> normal_pa, const Bias& zero) noexcept {
  for (std::size_t i = 0; i < taxels_; ++i) {
    const float load = normal_pa[i] - zero.bias_pa[i];
    if (load > pressed_pa_[i]) pressed_pa_[i] = load;  // never for what is no number
  }
}

void ZeroCheck::forget_pressed() noexcept {
  std::fill(pressed_pa_.begin(), pressed_pa_.end(), 0.0F);
}

float ZeroCheck::mean_off_pa(const Frame& reading, const Bias& zero) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < reading.normal_pa.size(); ++i) sum += reading.normal_pa[i] - zero.bias_pa[i];
  return static_cast<float>(sum / static_cast<double>(reading.normal_pa.size()));
}

}  // namespace slipd
