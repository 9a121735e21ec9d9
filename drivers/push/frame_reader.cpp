#include "drivers/push/frame_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace slipd::push {
namespace {

using push_layout::FrameHead;

// A sequence that jumps by more is no count of lost frames.
constexpr std::uint64_t kLongestJump = std::uint64_t{1} << 32;

// Whether all values are numbers that stay finite when they are scaled. In this form the loop is vectorized.
bool are_finite(const std::uint8_t* values, std::size_t count, const std::array<float, 3>& scale) noexcept {
  const float largest = std::max({1.0F, std::abs(scale[0]), std::abs(scale[1]), std::abs(scale[2])});
  const float limit = std::numeric_limits<float>::max() / largest;
  unsigned odd = 0;
  for (std::size_t i = 0; i < count; ++i) {
    float value = 0;
    std::memcpy(&value, values + i * sizeof value, sizeof value);
    odd |= std::abs(value) <= limit ? 0U : 1U;  // also of NaN
  }
  return odd == 0;
}

// Writes the values of a message into the slot, in Pa.
template <std::size_t axes>
void convert(const std::uint8_t* values, const std::array<float, 3>& scale, FrameSlot& slot) noexcept {
  // Nothing of these overlaps: the compiler cannot know.
  float* const __restrict x = slot.shear_x_pa.data();
  float* const __restrict y = slot.shear_y_pa.data();
  float* const __restrict z = slot.normal_pa.data();
  const auto [scale_x, scale_y, scale_z] = scale;
  const std::size_t taxels = slot.normal_pa.size();
  for (std::size_t i = 0; i < taxels; ++i) {
    std::array<float, axes> raw;
    std::memcpy(raw.data(), values + i * sizeof raw, sizeof raw);
    x[i] = axes == 3 ? scale_x * raw[0] : 0;
    y[i] = axes == 3 ? scale_y * raw[axes / 2] : 0;
    z[i] = scale_z * raw[axes - 1];
  }
}

}  // namespace

const char* describe(Refusal refusal) noexcept {
  static constexpr const char* kTexts[] = {
      "was a frame",
      "had not the size of a frame of this layout",
      "was of a version or had flags that this slipd does not know",
      "was marked as bad by the program",
      "had a sequence that did not rise",
      "was too old, or was sent without a time and waited behind another",
      "had a time that is in the future, or before the last one",
      "had values that are not finite"};
  return kTexts[static_cast<std::size_t>(refusal)];
}

void FrameReader::begin(const Agreement& agreed) noexcept {
  agreed_ = agreed;
  begun_ = false;
}

Refusal FrameReader::check(const FrameHead& head, std::size_t size, std::int64_t now_ns, bool waiting,
                           std::int64_t& time_ns) const noexcept {
  if (head.version != push_layout::kVersion || (head.flags & ~push_layout::kBad) != 0)
    return Refusal::unknown;
  if (head.size != size) return Refusal::wrong_size;
  if ((head.flags & push_layout::kBad) != 0) return Refusal::bad;
  if (begun_ && head.sequence - last_written_ - 1 >= kLongestJump) return Refusal::repeated;
  if (head.time_ns == 0 && waiting) return Refusal::too_old;
  time_ns = head.time_ns == 0 ? now_ns : head.time_ns;
  if (time_ns > now_ns || time_ns <= last_time_ns_) return Refusal::not_ordered;
  return now_ns - time_ns > max_age_ns_ ? Refusal::too_old : Refusal::none;
}

Refusal FrameReader::take(std::span<const std::uint8_t> message, std::int64_t now_ns, bool waiting,
                          FrameSlot& slot) noexcept {
  if (message.size() != push_layout::frame_size(agreed_.taxels, agreed_.axes)) return Refusal::wrong_size;
  FrameHead head;
  std::memcpy(&head, message.data(), sizeof head);
  std::int64_t time_ns = 0;
  const Refusal refusal = check(head, message.size(), now_ns, waiting, time_ns);
  if (refusal != Refusal::none) return refusal;
  const std::uint8_t* const values = message.data() + sizeof head;
  if (!are_finite(values, agreed_.taxels * agreed_.axes, agreed_.scale)) return Refusal::not_finite;
  agreed_.axes == 3 ? convert<3>(values, agreed_.scale, slot) : convert<1>(values, agreed_.scale, slot);
  last_sequence_ += begun_ ? head.sequence - last_written_ : 1;
  last_written_ = head.sequence;
  begun_ = true;
  last_time_ns_ = time_ns;
  slot.sequence = last_sequence_;
  slot.time_ns = time_ns;
  slot.device_time_ns = -1;
  slot.truth = {};
  return Refusal::none;
}

}  // namespace slipd::push
