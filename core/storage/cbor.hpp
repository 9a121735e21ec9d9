// The part of CBOR (RFC 8949) that a frame in a recording needs, written and read in place without
// allocation, exceptions or recursion. Everything else (the header) is parsed by nlohmann::json, after
// is_sound accepted it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace slipd::cbor {

// Tag of a byte string that is an array of little-endian float32 (RFC 8746).
inline constexpr std::uint64_t kFloat32LittleEndian = 85;

// Writes items one after another, without bounds checks: the caller provides enough memory. A head takes at
// most 9 bytes, a text its length in addition, an array 4 bytes a value in addition. Not thread-safe.
class Writer {
 public:
  explicit Writer(std::uint8_t* at) noexcept : at_(at) {}
  // The head of a map; 2 x `entries` items must follow.
  void map(std::uint64_t entries) noexcept { head(5, entries); }
  void text(std::string_view s) noexcept;
  void integer(std::int64_t v) noexcept;
  void unsigned_integer(std::uint64_t v) noexcept { head(0, v); }
  // NaN is written as null.
  void float64_or_null(double v) noexcept;
  void null() noexcept { *at_++ = 0xF6; }
  void float32_array(std::span<const float> values) noexcept;
  // An integer in 9 bytes, whatever its value.
  void fixed_unsigned(std::uint64_t v) noexcept;
  void fixed_integer(std::int64_t v) noexcept;
  // The head of a byte string, in 5 bytes; `bytes` bytes must follow. `bytes` is below 2^32.
  void fixed_bytes_head(std::size_t bytes) noexcept;
  void bytes(std::span<const std::uint8_t> bytes) noexcept;
  // Leaves so many bytes as they are.
  void pass_over(std::size_t bytes) noexcept { at_ += bytes; }
  // The first byte that was not written.
  const std::uint8_t* at() const noexcept { return at_; }

 private:
  void head(unsigned major, std::uint64_t value) noexcept;
  void head_of(unsigned major, unsigned info, int bytes, std::uint64_t value) noexcept;
  std::uint8_t* at_;
};

// Reads items one after another. The first item of another kind than requested sets fault(); every later call
// returns zeros. Not thread-safe.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  // The number of entries of a map.
  std::uint64_t map() noexcept { return head(5, "a map"); }
  // A text that must equal `expected`.
  void text(std::string_view expected) noexcept;
  std::uint64_t unsigned_integer() noexcept { return head(0, "a count"); }
  std::int64_t integer() noexcept;
  std::optional<std::int64_t> integer_or_null() noexcept;
  // Null is returned as NaN.
  double float64_or_null() noexcept;
  // Fills `out`. An array of another length is a fault.
  void float32_array(std::span<float> out) noexcept;

  // A byte string; it lies in the bytes that are read.
  std::span<const std::uint8_t> byte_string() noexcept;

  bool ok() const noexcept { return fault_ == nullptr; }
  // Whether the fault is that bytes are missing, and not that they are wrong.
  bool starved() const noexcept { return starved_; }
  // What was expected at the fault; null without a fault.
  const char* fault() const noexcept { return fault_; }
  // Bytes read so far; at a fault, its position.
  std::size_t position() const noexcept { return position_; }

  // Skips one item of any kind, of definite length and nested at most 16 deep.
  void skip() noexcept;

 private:
  struct Head {
    unsigned major = 0;
    unsigned info = 0;
    std::uint64_t value = 0;
  };
  Head any_head(const char* expected) noexcept;
  std::uint64_t head(unsigned major, const char* expected) noexcept;
  bool take_null() noexcept;
  void fail(const char* expected, bool starved) noexcept;

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  const char* fault_ = nullptr;
  bool starved_ = false;
};

// Whether `bytes` are exactly one item, of definite length throughout and nested at most 16 deep. Call it
// before a parser that recurses.
bool is_sound(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace slipd::cbor
