#include "lab/faults/fault.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lab {
namespace {

using slipd::Frame;
using slipd::FrameSlot;

constexpr float kSpikePa = 5e6F, kFarSpikePa = 1e8F, kAbsurdPa = 1e30F, kStuckBitPa = 4e5F;
constexpr float kClipPa = 5e3F, kDriftPaPerS = 2e3F, kWeak = 0.1F;
constexpr float kNoisePa = 2e4F, kLostGain = 0.3F, kLostZeroPa = 2e4F;
constexpr std::size_t kBlockFrames = 20, kDelayFrames = 10;
constexpr double kSecondsPerNs = 1e-9;

std::array<std::span<float>, 3> channels_of(FrameSlot& frame) {
  return {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa};
}

void fill(std::span<float> values, float with) {
  std::fill(values.begin(), values.end(), with);
}

void limit(std::span<float> values, float most) {
  for (float& value : values) value = std::clamp(value, -most, most);
}

float mean(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return static_cast<float>(sum / static_cast<double>(values.size()));
}

std::size_t peak_of(std::span<const float> values) {
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

}  // namespace

std::string_view name_of(Fault fault) noexcept {
  static constexpr std::array<std::string_view, kFaults> kNames{"none",
                                                                "dead_shear_x",
                                                                "dead_shear",
                                                                "stuck_shear_x",
                                                                "dead_normal",
                                                                "dead_row",
                                                                "spike_5mpa",
                                                                "spike_1e30",
                                                                "far_100mpa",
                                                                "stuck_bit",
                                                                "stuck_bit_channel",
                                                                "not_a_number",
                                                                "scale_1e-6",
                                                                "scale_1e3",
                                                                "scale_1e25",
                                                                "all_equal",
                                                                "frozen",
                                                                "repeated_block",
                                                                "doubled",
                                                                "delayed",
                                                                "time_stands",
                                                                "clipped_shear",
                                                                "clipped_normal",
                                                                "swapped_axes",
                                                                "transposed",
                                                                "other_finger",
                                                                "drift",
                                                                "weak_shear",
                                                                "turned_shear_x",
                                                                "dead_column",
                                                                "stuck_shear_bit",
                                                                "noisy_shear_x",
                                                                "lost_gains",
                                                                "lost_zeros"};
  return kNames[static_cast<std::size_t>(fault)];
}

FaultInjector::FaultInjector(Fault fault, const slipd::TaxelLayout& layout, std::uint64_t first,
                             const slipd::RandomStream& random)
    : fault_(fault), layout_(layout), first_(first), random_(random) {}

void FaultInjector::keep(const FrameSlot& frame, std::size_t most) {
  kept_.push_back({frame.time_ns,
                   {std::vector(frame.normal_pa.begin(), frame.normal_pa.end()),
                    std::vector(frame.shear_x_pa.begin(), frame.shear_x_pa.end()),
                    std::vector(frame.shear_y_pa.begin(), frame.shear_y_pa.end())}});
  while (kept_.size() > most) kept_.pop_front();
}

void FaultInjector::put(const Kept& kept, FrameSlot& frame) {
  const auto to = channels_of(frame);
  for (std::size_t c = 0; c < to.size(); ++c)
    std::copy(kept.values[c].begin(), kept.values[c].end(), to[c].begin());
}

void FaultInjector::spoil_taxels(FrameSlot& frame) const {
  const auto& grid = layout_.regular();
  const std::size_t middle =
      grid ? grid->rows / 2 * grid->columns + grid->columns / 2 : frame.normal_pa.size() / 2;
  float& at_middle = frame.normal_pa[middle];
  switch (fault_) {
    case Fault::spike_5mpa:
      at_middle = kSpikePa;
      break;
    case Fault::spike_1e30:
      at_middle = kAbsurdPa;
      break;
    case Fault::far_100mpa:
      frame.normal_pa.back() = kFarSpikePa;
      break;
    case Fault::stuck_shear_bit:
      frame.shear_x_pa[middle] += kStuckBitPa;
      break;
    case Fault::stuck_bit:
      at_middle += kStuckBitPa;
      break;
    case Fault::not_a_number:
      at_middle = std::numeric_limits<float>::quiet_NaN();
      break;
    default:
      break;
  }
}

// A row or a column of the grid; of another layout nothing.
void FaultInjector::spoil_line(FrameSlot& frame) const {
  const auto& grid = layout_.regular();
  if (!grid) return;
  for (const auto values : channels_of(frame)) {
    if (fault_ == Fault::dead_row) fill(values.subspan(grid->rows / 2 * grid->columns, grid->columns), 0);
    if (fault_ != Fault::dead_column) continue;
    for (std::size_t i = grid->columns / 2; i < values.size(); i += grid->columns) values[i] = 0;
  }
}

void FaultInjector::spoil_calibration(FrameSlot& frame) const {
  const std::size_t taxels = frame.normal_pa.size();
  for (std::size_t i = 0; i < taxels; ++i) {
    if (fault_ == Fault::lost_zeros) frame.normal_pa[i] += kLostZeroPa * random_.noise(i);
    if (fault_ == Fault::noisy_shear_x) {
      frame.shear_x_pa[i] += kNoisePa * random_.noise(taxels * since_ + i);
    } else if (fault_ == Fault::lost_gains) {
      const float gain = 1 + kLostGain * random_.noise(i);
      for (const auto values : channels_of(frame)) values[i] *= gain;
    }
  }
}

void FaultInjector::spoil_channels(FrameSlot& frame) {
  const auto scale = [&](float by) {
    for (const auto values : channels_of(frame)) {
      for (float& value : values) value *= by;
    }
  };
  switch (fault_) {
    case Fault::dead_shear_x:
      return fill(frame.shear_x_pa, 0);
    case Fault::dead_shear:
      fill(frame.shear_x_pa, 0);
      return fill(frame.shear_y_pa, 0);
    case Fault::dead_normal:
      return fill(frame.normal_pa, 0);
    case Fault::stuck_bit_channel:
      for (float& value : frame.normal_pa) value += kStuckBitPa;
      return;
    case Fault::scale_1e_6:
      return scale(1e-6F);
    case Fault::scale_1e3:
      return scale(1e3F);
    case Fault::scale_1e25:
      return scale(1e25F);
    case Fault::all_equal:
      for (const auto values : channels_of(frame)) fill(values, mean(values));
      return;
    case Fault::clipped_shear:
      limit(frame.shear_x_pa, kClipPa);
      return limit(frame.shear_y_pa, kClipPa);
    case Fault::clipped_normal:
      if (since_ == 0) limit_pa_ = frame.normal_pa[peak_of(frame.normal_pa)] / 2;
      return limit(frame.normal_pa, limit_pa_);
    case Fault::swapped_axes:
      std::swap_ranges(frame.shear_x_pa.begin(), frame.shear_x_pa.end(), frame.shear_y_pa.begin());
      return;
    case Fault::weak_shear:
      for (float& value : frame.shear_x_pa) value *= kWeak;
      return;
    case Fault::turned_shear_x:
      for (float& value : frame.shear_x_pa) value = -value;
      return;
    default:
      return;
  }
}

void FaultInjector::spoil_course(FrameSlot& frame, const Frame& other) {
  switch (fault_) {
    case Fault::stuck_shear_x:
      std::copy(kept_.front().values[1].begin(), kept_.front().values[1].end(), frame.shear_x_pa.begin());
      break;
    case Fault::frozen:
      put(kept_.back(), frame);
      break;
    case Fault::repeated_block:
    case Fault::delayed:
      if (fault_ == Fault::delayed) keep(frame, kDelayFrames + 1);
      put(kept_[fault_ == Fault::delayed ? 0 : since_ % kept_.size()], frame);
      break;
    case Fault::doubled:
      if (since_ % 2 == 0) {
        keep(frame, 1);
      } else {
        put(kept_.back(), frame);
      }
      break;
    case Fault::time_stands:
      frame.time_ns = kept_.back().time_ns;
      break;
    case Fault::transposed:
      if (const auto& grid = layout_.regular(); grid && grid->columns == grid->rows) {
        for (const auto values : channels_of(frame)) {
          for (std::size_t row = 0; row < grid->rows; ++row) {
            for (std::size_t column = 0; column < row; ++column)
              std::swap(values[row * grid->columns + column], values[column * grid->columns + row]);
          }
        }
      }
      break;
    case Fault::other_finger:
      std::copy(other.normal_pa.begin(), other.normal_pa.end(), frame.normal_pa.begin());
      std::copy(other.shear_x_pa.begin(), other.shear_x_pa.end(), frame.shear_x_pa.begin());
      std::copy(other.shear_y_pa.begin(), other.shear_y_pa.end(), frame.shear_y_pa.begin());
      break;
    case Fault::drift: {
      const auto passed_s =
          static_cast<float>(kSecondsPerNs * static_cast<double>(frame.time_ns - kept_.back().time_ns));
      for (std::size_t i = 0; i < frame.normal_pa.size(); ++i)
        frame.normal_pa[i] += kDriftPaPerS * passed_s * random_.noise(i);
      break;
    }
    default:
      break;
  }
}

void FaultInjector::spoil(FrameSlot& frame, const Frame& other) {
  if (frame.sequence < first_) {
    keep(frame, fault_ == Fault::delayed ? kDelayFrames : kBlockFrames);
    if (fault_ == Fault::stuck_shear_x || fault_ == Fault::frozen)
      kept_.erase(kept_.begin(), kept_.end() - 1);
    return;
  }
  if (kept_.empty()) keep(frame, 1);
  spoil_taxels(frame);
  spoil_line(frame);
  spoil_calibration(frame);
  spoil_channels(frame);
  spoil_course(frame, other);
  ++since_;
}

}  // namespace lab
