// The bytes of MCAP's records: little-endian numbers, texts and maps. Any thread that may allocate.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace slipd::ros2 {

// What a file begins and ends with.
inline constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class McapOp : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  statistics = 0x0B,
  summary_offset = 0x0E,
  data_end = 0x0F
};

// Appends one record: the opcode, the length of the content, filled in by end(), and the content.
class McapRecord {
 public:
  McapRecord(std::vector<std::uint8_t>& out, McapOp op) : out_(out) {
    out_.push_back(static_cast<std::uint8_t>(op));
    length_at_ = out_.size();
    number(std::uint64_t{0});
  }

  template <std::unsigned_integral T>
  McapRecord& number(T value) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof value);
    std::memcpy(out_.data() + at, &value, sizeof value);
    return *this;
  }
  McapRecord& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    out_.insert(out_.end(), text.begin(), text.end());
    return *this;
  }
  McapRecord& raw(std::span<const std::uint8_t> bytes) {
    out_.insert(out_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  // A map or array: its length in bytes, filled in when `fill` is done, and what `fill` appends.
  template <class Fill>
  McapRecord& list(Fill fill) {
    const std::size_t at = out_.size();
    number(std::uint32_t{0});
    fill(*this);
    const auto bytes = static_cast<std::uint32_t>(out_.size() - at - sizeof(std::uint32_t));
    std::memcpy(out_.data() + at, &bytes, sizeof bytes);
    return *this;
  }
  void end() {
    const std::uint64_t bytes = out_.size() - length_at_ - sizeof(std::uint64_t);
    std::memcpy(out_.data() + length_at_, &bytes, sizeof bytes);
  }

 private:
  std::vector<std::uint8_t>& out_;
  std::size_t length_at_ = 0;
};

}  // namespace slipd::ros2
