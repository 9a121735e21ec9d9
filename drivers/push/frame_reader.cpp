#include "drivers/push/frame_reader.hpp"

#include <bit>
#include <cstring>

namespace slipd::push {
namespace {

using push_layout::FrameHead;

// A sequence that jumps by more is no count of lost frames.
constexpr std::uint64_t kLongestJump = std::uint64_t{1} << 32;

// 1 for an infinite value or NaN. In this form the loop over taxels is vectorized.
std::uint32_t is_odd(float value) noexcept {
  constexpr std::uint32_t kExponent = 0x7F80'0000;
  return (std::bit_cast<std::uint32_t>(value) & kExponent) == kExponent ? 1 : 0;
}

// Writes the values of a message into the slot, in Pa. False: one of them is not finite.
template <std::size_t axes>
bool convert(const std::uint8_t* values, const std::array<float, 3>& scale, FrameSlot& slot) noexcept {
  std::uint32_t odd = 0;
  float* const x = slot.shear_x_pa.data();
  float* const y = slot.shear_y_pa.data();
  float* const z = slot.normal_pa.data();
  const std::size_t taxels = slot.normal_pa.size();
  for (std::size_t i = 0; i < taxels; ++i) {
    std::array<float, axes> raw;
    std::memcpy(raw.data(), values + i * sizeof raw, sizeof raw);
    x[i] = axes == 3 ? scale[0] * raw[0] : 0;
    y[i] = axes == 3 ? scale[1] * raw[axes / 2] : 0;
    z[i] = scale[2] * raw[axes - 1];
    odd |= is_odd(x[i]) | is_odd(y[i]) | is_odd(z[i]);
  }
  return odd == 0;
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
  const bool finite =
      agreed_.axes == 3 ? convert<3>(values, agreed_.scale, slot) : convert<1>(values, agreed_.scale, slot);
  if (!finite) return Refusal::not_finite;
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
