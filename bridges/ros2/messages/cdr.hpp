// Messages as bytes: CDR as DDS and MCAP carry it (OMG XTypes 1.3, 7.4: XCDR version 1, final,
// little-endian), with the four bytes of the encapsulation header in front. Any thread.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "bridges/ros2/messages/messages.hpp"

namespace slipd::ros2 {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

template <class T>
concept Message = requires {
  T::kName;
};

// Appends fields to `out`, which it clears first. Alignment counts from the end of the header.
class CdrWriter {
 public:
  explicit CdrWriter(std::vector<std::uint8_t>& out) : out_(out) {
    out_.assign(kHeader.begin(), kHeader.end());
  }

  template <class T>
  void operator()(std::string_view /*name*/, const T& value) {
    put(value);
  }

  template <Message T>
  void put(const T& message) {
    T::fields(message, *this);
  }

 private:
  // Little-endian CDR, no options.
  static constexpr std::array<std::uint8_t, 4> kHeader{0, 1, 0, 0};

  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) {
    const std::size_t at = grow(sizeof(T), sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }
  void put(Byte byte) { put(byte.value); }
  // The length counts the zero behind the text.
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    const std::size_t at = grow(1, text.size() + 1);
    std::memcpy(out_.data() + at, text.c_str(), text.size() + 1);
  }
  // What is too long is cut.
  template <std::size_t MOST>
  void put(const BoundedString<MOST>& bounded) {
    put(bounded.text.substr(0, MOST));
  }
  template <class T>
  void put(const std::vector<T>& sequence) {
    put(static_cast<std::uint32_t>(sequence.size()));
    for (const T& element : sequence) put(element);
  }
  void put(const std::vector<std::uint8_t>& bytes) {
    put(static_cast<std::uint32_t>(bytes.size()));
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& array) {
    for (const T& element : array) put(element);
  }

  // Aligns, adds zeros for `bytes`, and returns where they begin.
  std::size_t grow(std::size_t alignment, std::size_t bytes) {
    const std::size_t body = out_.size() - kHeader.size();
    const std::size_t at = kHeader.size() + (body + alignment - 1) / alignment * alignment;
    out_.resize(at + bytes);
    return at;
  }

  std::vector<std::uint8_t>& out_;
};

// Writes the message with its encapsulation header to `out`, whose memory is reused.
template <Message T>
void encode(const T& message, std::vector<std::uint8_t>& out) {
  CdrWriter(out).put(message);
}

}  // namespace slipd::ros2
