#include "drivers/decode/pts2.hpp"

#include <algorithm>

#include "wire/number.hpp"

namespace slipd::decode {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kTypeBytes = 2;
constexpr std::uint64_t kTime = 1, kPillars = 3, kForceAndDisplacement = 2;

class Reader {
 public:
  explicit Reader(Bytes in) noexcept : in_(in), width_(in.empty() ? 0 : in[0]) {}

  bool flatten(std::size_t sensors, std::size_t pillars, std::span<std::uint8_t> out) noexcept {
    std::ranges::fill(out, std::uint8_t{0xFF});  // as floats: NaN
    if (width_ != 1 && width_ != 2 && width_ != 4) return false;
    std::size_t first = in_.size();  // offset of the first block
    std::size_t time = 0, forces = 0;
    for (std::size_t at = 1; at + kTypeBytes + width_ <= first; at += kTypeBytes + width_) {
      const std::uint64_t type = number(at, kTypeBytes);
      if (type == 0) break;
      const std::uint64_t offset = number(at + kTypeBytes, width_);
      if (offset == 0 || offset >= in_.size()) return false;
      first = std::min(first, static_cast<std::size_t>(offset));
      if (type == kTime) time = offset;
      if (type == kPillars) forces = offset;
    }
    if (time == 0 || forces == 0 || time + kPts2Head > in_.size()) return false;
    std::copy_n(in_.begin() + static_cast<std::ptrdiff_t>(time), kPts2Head, out.begin());
    const std::uint64_t there = number(forces, width_);
    for (std::size_t i = 0; i < sensors && i < there; ++i) {
      if (!sensor(item(forces, i), pillars, out.subspan(kPts2Head + i * pillars * kPts2Pillar))) return false;
    }
    return ok_;
  }

 private:
  // 0 behind the end; then the packet is invalid.
  std::uint64_t number(std::size_t at, std::size_t bytes) noexcept {
    if (at + bytes > in_.size()) {
      ok_ = false;
      return 0;
    }
    return wire::read_bits(in_.data() + at, bytes, false);
  }

  // Offset i of a list that begins at `at`.
  std::size_t item(std::size_t at, std::size_t i) noexcept { return number(at + width_ * (1 + i), width_); }

  bool sensor(std::size_t at, std::size_t pillars, std::span<std::uint8_t> out) noexcept {
    if (number(at, width_) != pillars || !ok_) return false;
    for (std::size_t i = 0; i < pillars; ++i) {
      const std::size_t pillar = item(at, i);
      if (number(pillar, kTypeBytes) != kForceAndDisplacement || !ok_) return false;
      const std::size_t values = pillar + kTypeBytes;
      if (values + kPts2Pillar > in_.size()) return false;
      std::copy_n(in_.begin() + static_cast<std::ptrdiff_t>(values), kPts2Pillar,
                  out.begin() + static_cast<std::ptrdiff_t>(i * kPts2Pillar));
    }
    return true;
  }

  Bytes in_;
  std::size_t width_;
  bool ok_ = true;
};

}  // namespace

bool flatten_pts2(Bytes in, std::size_t sensors, std::size_t pillars, std::span<std::uint8_t> out) noexcept {
  return Reader(in).flatten(sensors, pillars, out);
}

}  // namespace slipd::decode
