// Messages as bytes: CDR as DDS and MCAP carry it (OMG XTypes 1.3, 7.4: XCDR version 1, final), with the four
// bytes of the encapsulation header in front. Written little-endian, read in both orders. Any thread.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
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

// Reads fields from bytes, any of which are valid input. A message that is cut off, or whose texts do not end
// with a zero, is none. Bytes behind the last field are left: writers add some for alignment.
class CdrReader {
 public:
  // `bytes`: with the encapsulation header.
  explicit CdrReader(std::span<const std::uint8_t> bytes) {
    whole_ = bytes.size() >= kHeaderBytes && bytes[0] == 0 && bytes[1] <= 1;
    if (!whole_) return;
    swapped_ = bytes[1] == 0;
    bytes_ = bytes.subspan(kHeaderBytes);
  }

  // Whether all fields so far were there.
  bool whole() const noexcept { return whole_; }

  template <class T>
  void operator()(std::string_view /*name*/, T& value) {
    get(value);
  }

  template <Message T>
  void get(T& message) {
    T::fields(message, *this);
  }

 private:
  static constexpr std::size_t kHeaderBytes = 4;

  template <class T>
  requires std::is_arithmetic_v<T>
  void get(T& value) {
    align(sizeof(T));
    const auto from = take(sizeof(T));
    if (!whole_) return;
    std::array<std::uint8_t, sizeof(T)> raw{};
    std::copy(from.begin(), from.end(), raw.begin());
    if (swapped_) std::reverse(raw.begin(), raw.end());
    if constexpr (std::is_same_v<T, bool>) {
      value = raw[0] != 0;
    } else {
      std::memcpy(&value, raw.data(), sizeof(T));
    }
  }
  void get(Byte& byte) { get(byte.value); }
  void get(std::string& text) {
    const auto from = take(length());
    whole_ = whole_ && !from.empty() && from.back() == 0;
    if (whole_) text.assign(from.begin(), from.end() - 1);
  }
  template <std::size_t MOST>
  void get(BoundedString<MOST>& bounded) {
    get(bounded.text);
    whole_ = whole_ && bounded.text.size() <= MOST;
  }
  // Memory grows with the elements that are there, whatever the length says.
  template <class T>
  void get(std::vector<T>& sequence) {
    sequence.clear();
    for (std::uint32_t left = length(); left > 0 && whole_; --left) get(sequence.emplace_back());
  }
  void get(std::vector<std::uint8_t>& bytes) {
    const auto from = take(length());
    bytes.assign(from.begin(), from.end());
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& array) {
    for (T& element : array) get(element);
  }

  std::uint32_t length() {
    std::uint32_t length = 0;
    get(length);
    return whole_ ? length : 0;
  }
  void align(std::size_t alignment) { at_ = (at_ + alignment - 1) / alignment * alignment; }
  std::span<const std::uint8_t> take(std::size_t bytes) {
    whole_ = whole_ && at_ <= bytes_.size() && bytes <= bytes_.size() - at_;
    if (!whole_) return {};
    const auto taken = bytes_.subspan(at_, bytes);
    at_ += bytes;
    return taken;
  }

  std::span<const std::uint8_t> bytes_;  // behind the header
  std::size_t at_ = 0;
  bool swapped_ = false, whole_ = false;
};

// Reads the message behind its encapsulation header into `message`, whose memory is reused. False: the bytes
// are none of this type.
template <Message T>
bool decode(std::span<const std::uint8_t> bytes, T& message) {
  CdrReader reader(bytes);
  reader.get(message);
  return reader.whole();
}

}  // namespace slipd::ros2
