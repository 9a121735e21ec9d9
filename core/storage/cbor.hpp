// The few pieces of CBOR (RFC 8949) that a frame in a recording is made of, written and read in place: no
// allocation, no exception, no recursion. Everything richer (the header) goes through nlohmann's, once
// item_size has shown it sound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace slipd::cbor {

inline constexpr std::uint64_t kFloat32LittleEndian = 85;  // tag of RFC 8746, a typed array in a byte string

// Appends to memory that the caller has made large enough: a head takes at most 9 bytes, a text its length
// more.
class Writer {
 public:
  explicit Writer(std::uint8_t* at) noexcept : at_(at) {}
  void map(std::uint64_t entries) noexcept { head(5, entries); }
  void text(std::string_view s) noexcept;
  void integer(std::int64_t v) noexcept;
  void unsigned_integer(std::uint64_t v) noexcept { head(0, v); }
  void float64_or_null(double v) noexcept;  // NaN is null
  void null() noexcept { *at_++ = 0xF6; }
  void float32_array(std::span<const float> values) noexcept;
  const std::uint8_t* at() const noexcept { return at_; }

 private:
  void head(unsigned major, std::uint64_t value) noexcept;
  std::uint8_t* at_;
};

// Reads items one after another. The first thing that is not as asked for sets fault() and ends the reading:
// everything after returns zeros. starved() tells a fault of bytes that are missing from one of bytes that
// are wrong.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  std::uint64_t map() noexcept { return head(5, "a map"); }
  void text(std::string_view expected) noexcept;
  std::uint64_t unsigned_integer() noexcept { return head(0, "a count"); }
  std::int64_t integer() noexcept;
  std::optional<std::int64_t> integer_or_null() noexcept;
  double float64_or_null() noexcept;  // null is NaN
  // Fills `out`; an array of another length is a fault.
  void float32_array(std::span<float> out) noexcept;

  bool ok() const noexcept { return fault_ == nullptr; }
  bool starved() const noexcept { return starved_; }
  const char* fault() const noexcept { return fault_; }        // what was expected; null without a fault
  std::size_t position() const noexcept { return position_; }  // bytes read; at a fault, where it is

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

// Whether these bytes are one item, all of definite length and nested at most 16 deep: to be asked before a
// parser that recurses sees them.
bool is_sound(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace slipd::cbor
