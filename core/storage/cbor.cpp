#include "core/storage/cbor.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace slipd::cbor {

static_assert(std::endian::native == std::endian::little, "float arrays are copied as they lie in memory");

namespace {
constexpr std::size_t kDeepest = 16;
constexpr unsigned kInfo4Bytes = 26, kInfo8Bytes = 27;  // the value of an item follows in so many bytes
constexpr std::uint8_t kNull = 0xF6;
constexpr std::uint8_t kFloat64 = 0xFB;
}  // namespace

void Writer::head(unsigned major, std::uint64_t value) noexcept {
  int bytes = 8;
  unsigned info = kInfo8Bytes;
  if (value < 24) {
    bytes = 0;
    info = static_cast<unsigned>(value);
  } else if (value <= 0xFF) {
    bytes = 1;
    info = 24;
  } else if (value <= 0xFFFF) {
    bytes = 2;
    info = 25;
  } else if (value <= 0xFFFFFFFF) {
    bytes = 4;
    info = kInfo4Bytes;
  }
  head_of(major, info, bytes, value);
}

void Writer::head_of(unsigned major, unsigned info, int bytes, std::uint64_t value) noexcept {
  *at_++ = static_cast<std::uint8_t>(major << 5 | info);
  for (int i = bytes - 1; i >= 0; --i) *at_++ = static_cast<std::uint8_t>(value >> (8 * i));
}

void Writer::fixed_unsigned(std::uint64_t v) noexcept {
  head_of(0, kInfo8Bytes, 8, v);
}

void Writer::fixed_integer(std::int64_t v) noexcept {
  if (v >= 0) return fixed_unsigned(static_cast<std::uint64_t>(v));
  head_of(1, kInfo8Bytes, 8, static_cast<std::uint64_t>(-1 - v));
}

void Writer::fixed_bytes_head(std::size_t bytes) noexcept {
  head_of(2, kInfo4Bytes, 4, bytes);
}

void Writer::bytes(std::span<const std::uint8_t> bytes) noexcept {
  if (!bytes.empty()) std::memcpy(at_, bytes.data(), bytes.size());
  at_ += bytes.size();
}

void Writer::text(std::string_view s) noexcept {
  head(3, s.size());
  std::memcpy(at_, s.data(), s.size());
  at_ += s.size();
}

void Writer::integer(std::int64_t v) noexcept {
  if (v >= 0) {
    head(0, static_cast<std::uint64_t>(v));
  } else {
    head(1, static_cast<std::uint64_t>(-1 - v));
  }
}

void Writer::float64_or_null(double v) noexcept {
  if (std::isnan(v)) return null();
  *at_++ = kFloat64;
  const auto bits = std::bit_cast<std::uint64_t>(v);
  for (int i = 7; i >= 0; --i) *at_++ = static_cast<std::uint8_t>(bits >> (8 * i));
}

void Writer::float32_array(std::span<const float> values) noexcept {
  head(6, kFloat32LittleEndian);
  head(2, values.size_bytes());
  std::memcpy(at_, values.data(), values.size_bytes());
  at_ += values.size_bytes();
}

void Reader::fail(const char* expected, bool starved) noexcept {
  if (fault_ != nullptr) return;
  fault_ = expected;
  starved_ = starved;
}

Reader::Head Reader::any_head(const char* expected) noexcept {
  if (!ok()) return {};
  if (position_ == bytes_.size()) {
    fail(expected, true);
    return {};
  }
  const std::uint8_t first = bytes_[position_];
  Head head{static_cast<unsigned>(first >> 5), static_cast<unsigned>(first & 31), 0};
  if (head.info < 24) {
    head.value = head.info;
    ++position_;
    return head;
  }
  if (head.info > 27) {
    fail(expected, false);  // a reserved value, or an item of indefinite length
    return {};
  }
  const std::size_t more = std::size_t{1} << (head.info - 24);
  if (bytes_.size() - position_ - 1 < more) {
    fail(expected, true);
    return {};
  }
  for (std::size_t i = 1; i <= more; ++i) head.value = head.value << 8 | bytes_[position_ + i];
  position_ += 1 + more;
  return head;
}

std::uint64_t Reader::head(unsigned major, const char* expected) noexcept {
  const std::size_t start = position_;
  const Head h = any_head(expected);
  if (!ok() || h.major == major) return h.value;
  position_ = start;
  fail(expected, false);
  return 0;
}

void Reader::text(std::string_view expected) noexcept {
  const std::size_t start = position_;
  const std::uint64_t length = head(3, "the name of an entry");
  if (!ok()) return;
  const std::size_t left = bytes_.size() - position_;
  if (length == expected.size() && left < length) return fail("the name of an entry", true);
  if (length != expected.size() || std::memcmp(&bytes_[position_], expected.data(), length) != 0) {
    position_ = start;
    return fail("another entry", false);
  }
  position_ += length;
}

std::int64_t Reader::integer() noexcept {
  const std::size_t start = position_;
  const Head h = any_head("an integer");
  if (!ok()) return 0;
  if (h.major > 1 || h.value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
    position_ = start;
    fail("an integer of 64 bits", false);
    return 0;
  }
  const auto v = static_cast<std::int64_t>(h.value);
  return h.major == 0 ? v : -1 - v;
}

bool Reader::take_null() noexcept {
  if (!ok() || position_ == bytes_.size() || bytes_[position_] != kNull) return false;
  ++position_;
  return true;
}

std::optional<std::int64_t> Reader::integer_or_null() noexcept {
  if (take_null()) return std::nullopt;
  return integer();
}

double Reader::float64_or_null() noexcept {
  if (take_null()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t start = position_;
  const Head h = any_head("a float of 64 bits or null");
  if (!ok()) return 0;
  if (h.major != 7 || h.info != 27) {
    position_ = start;
    fail("a float of 64 bits or null", false);
    return 0;
  }
  return std::bit_cast<double>(h.value);
}

void Reader::float32_array(std::span<float> out) noexcept {
  const std::size_t start = position_;
  const std::uint64_t tag = head(6, "an array of float32 (tag 85)");
  const std::uint64_t bytes = head(2, "an array of float32 in a byte string");
  if (!ok()) return;
  if (tag != kFloat32LittleEndian || bytes != out.size_bytes()) {
    position_ = start;
    return fail("an array of float32 (tag 85) with one value a taxel", false);
  }
  if (bytes_.size() - position_ < bytes) {
    position_ = bytes_.size();
    return fail("an array of float32", true);
  }
  if (bytes != 0) std::memcpy(out.data(), &bytes_[position_], bytes);
  position_ += bytes;
}

std::span<const std::uint8_t> Reader::byte_string() noexcept {
  const std::uint64_t length = head(2, "a byte string");
  if (!ok()) return {};
  if (bytes_.size() - position_ < length) {
    position_ = bytes_.size();
    fail("a byte string", true);
    return {};
  }
  const auto found = bytes_.subspan(position_, length);
  position_ += length;
  return found;
}

void Reader::skip() noexcept {
  std::array<std::uint64_t, kDeepest> left{1};
  std::size_t depth = 1;
  while (depth > 0 && ok()) {
    if (left[depth - 1] == 0) {
      --depth;
      continue;
    }
    --left[depth - 1];
    const Head h = any_head("an item of definite length");
    if (!ok()) return;
    std::uint64_t inner = 0;
    switch (h.major) {
      case 2:
      case 3:
        if (bytes_.size() - position_ < h.value) return fail("a string", true);
        position_ += h.value;
        break;
      case 4:
        inner = h.value;
        break;
      case 5:
        if (h.value > std::numeric_limits<std::uint64_t>::max() / 2)
          return fail("a map of some length", false);
        inner = 2 * h.value;
        break;
      case 6:
        inner = 1;
        break;
      default:
        break;
    }
    if (inner == 0) continue;
    if (depth == kDeepest) return fail("items nested less deep", false);
    left[depth++] = inner;
  }
}

bool is_sound(std::span<const std::uint8_t> bytes) noexcept {
  Reader reader(bytes);
  reader.skip();
  return reader.ok() && reader.position() == bytes.size();
}

}  // namespace slipd::cbor
