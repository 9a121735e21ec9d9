#include "drivers/push/frame_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace slipd::push {
namespace {

using push_layout::FrameHead;

// A sequence that jumps by more is no count of lost frames.
constexpr std::uint64_t kLongestJump = std::uint64_t{1} << 32;

using Four = float __attribute__((vector_size(16)));

// Values where they arrive. Volatile reads them once: in shared memory a writer may change them meanwhile,
// and what was found to be finite has to be what is used.
// Packed: they may lie at any address. (Clang takes no notice of `aligned(1)` for a vector that is volatile.)
struct __attribute__((packed, may_alias)) FourThere {
  Four value;
};
struct __attribute__((packed, may_alias)) OneThere {
  float value;
};

Four load(const std::uint8_t* from) noexcept {
  return reinterpret_cast<const volatile FourThere*>(from)->value;
}

// Writes one value of a taxel, in Pa. `odd` becomes NaN if a value is not finite.
void put(const std::uint8_t* value, float scale, float& to, float& odd) noexcept {
  const float scaled = scale * reinterpret_cast<const volatile OneThere*>(value)->value;
  to = scaled;
  odd += 0 * scaled;
}

// Writes the values of a message with three axes into the slot, in Pa. False: one of them is not finite. Four
// taxels at a time, because compilers take threefold strides apart value by value, in twice the time.
bool convert_three(const std::uint8_t* values, const std::array<float, 3>& scale, FrameSlot& slot) noexcept {
  constexpr std::size_t kTaxelBytes = 3 * sizeof(float);
  const std::size_t taxels = slot.normal_pa.size();
  Four odd{};
  std::size_t i = 0;
  for (; i + 4 <= taxels; i += 4) {
    const std::uint8_t* const at = values + i * kTaxelBytes;
    const Four a = load(at), b = load(at + 16), c = load(at + 32);  // xyzx yzxy zxyz
    const Four x =
        scale[0] * __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 3, 6, 6), c, 0, 1, 2, 5);
    const Four y =
        scale[1] * __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 4, 7, 7), c, 0, 1, 2, 6);
    const Four z =
        scale[2] * __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 5, 5, 5), c, 0, 1, 4, 7);
    std::memcpy(&slot.shear_x_pa[i], &x, sizeof x);
    std::memcpy(&slot.shear_y_pa[i], &y, sizeof y);
    std::memcpy(&slot.normal_pa[i], &z, sizeof z);
    odd += 0 * x + 0 * y + 0 * z;
  }
  float sum = odd[0] + odd[1] + odd[2] + odd[3];
  for (; i < taxels; ++i) {
    const std::uint8_t* const at = values + i * kTaxelBytes;
    put(at, scale[0], slot.shear_x_pa[i], sum);
    put(at + sizeof(float), scale[1], slot.shear_y_pa[i], sum);
    put(at + 2 * sizeof(float), scale[2], slot.normal_pa[i], sum);
  }
  return sum == 0;
}

// The same of a message with one axis.
bool convert_one(const std::uint8_t* values, float scale, FrameSlot& slot) noexcept {
  std::ranges::fill(slot.shear_x_pa, 0.0F);
  std::ranges::fill(slot.shear_y_pa, 0.0F);
  float sum = 0;
  for (std::size_t i = 0; i < slot.normal_pa.size(); ++i)
    put(values + i * sizeof(float), scale, slot.normal_pa[i], sum);
  return sum == 0;
}

// Whether the slot holds displacements: a point is seen, or along x and y it is not; what the picture has
// changed by is known.
bool holds_displacements(const FrameSlot& slot) noexcept {
  for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
    const float x = slot.shear_x_pa[i], y = slot.shear_y_pa[i];
    const bool seen = std::isfinite(x) && std::isfinite(y);
    if (!std::isfinite(slot.normal_pa[i]) || (!seen && !(std::isnan(x) && std::isnan(y)))) return false;
  }
  return true;
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
      "had values that are not finite",
      "had values in shared memory that were not whole"};
  return kTexts[static_cast<std::size_t>(refusal)];
}

void FrameReader::begin(const Agreement& agreed) noexcept {
  agreed_ = agreed;
  begun_ = false;
}

Refusal FrameReader::check(const FrameHead& head, std::size_t size, std::int64_t now_ns, bool waiting,
                           std::int64_t& time_ns) const noexcept {
  if (head.version != push_layout::kVersion ||
      (head.flags & ~(push_layout::kBad | push_layout::kInRing)) != 0)
    return Refusal::unknown;
  if (head.size != size) return Refusal::wrong_size;
  if ((head.flags & push_layout::kBad) != 0) return Refusal::bad;
  if (begun_ && head.sequence - last_written_ - 1 >= kLongestJump) return Refusal::repeated;
  if (head.time_ns == 0 && waiting) return Refusal::too_old;
  time_ns = head.time_ns == 0 ? now_ns : head.time_ns;
  if (time_ns > now_ns || time_ns <= last_time_ns_) return Refusal::not_ordered;
  return now_ns - time_ns > max_age_ns_ ? Refusal::too_old : Refusal::none;
}

bool FrameReader::take_values(const std::uint8_t* values, FrameSlot& slot) const noexcept {
  const bool finite = agreed_.axes == 3 ? convert_three(values, agreed_.scale, slot)
                                        : convert_one(values, agreed_.scale[2], slot);
  return finite || (agreed_.displacement && holds_displacements(slot));
}

void FrameReader::keep(const FrameHead& head, std::int64_t time_ns, FrameSlot& slot) noexcept {
  last_sequence_ += begun_ ? head.sequence - last_written_ : 1;
  last_written_ = head.sequence;
  begun_ = true;
  last_time_ns_ = time_ns;
  slot.sequence = last_sequence_;
  slot.time_ns = time_ns;
  slot.device_time_ns = -1;
  slot.truth = {};
}

Refusal FrameReader::take_from_ring(std::span<const std::uint8_t> message, FrameRing& ring,
                                    std::int64_t now_ns, bool waiting, FrameSlot& slot) noexcept {
  push_layout::Notice notice;
  if (message.size() != sizeof notice ||
      push_layout::frame_size(agreed_.taxels, agreed_.axes) != sizeof(FrameHead) + ring.values_bytes())
    return Refusal::wrong_size;
  std::memcpy(&notice, message.data(), sizeof notice);
  if ((notice.head.flags & push_layout::kInRing) == 0) return Refusal::wrong_size;
  std::int64_t time_ns = 0;
  Refusal refusal = check(notice.head, message.size(), now_ns, waiting, time_ns);
  if (refusal == Refusal::none) {
    const bool whole = ring.holds(notice.frame);
    const bool finite = whole && take_values(ring.values(notice.frame), slot);
    if (!whole || !ring.holds(notice.frame))
      refusal = Refusal::torn;
    else if (!finite)
      refusal = Refusal::not_finite;
  }
  ring.give_back(notice.frame);
  if (refusal == Refusal::none) keep(notice.head, time_ns, slot);
  return refusal;
}

Refusal FrameReader::take(std::span<const std::uint8_t> message, std::int64_t now_ns, bool waiting,
                          FrameSlot& slot) noexcept {
  if (message.size() != push_layout::frame_size(agreed_.taxels, agreed_.axes)) return Refusal::wrong_size;
  FrameHead head;
  std::memcpy(&head, message.data(), sizeof head);
  if ((head.flags & push_layout::kInRing) != 0) return Refusal::unknown;
  std::int64_t time_ns = 0;
  const Refusal refusal = check(head, message.size(), now_ns, waiting, time_ns);
  if (refusal != Refusal::none) return refusal;
  if (!take_values(message.data() + sizeof head, slot)) return Refusal::not_finite;
  keep(head, time_ns, slot);
  return Refusal::none;
}

}  // namespace slipd::push
