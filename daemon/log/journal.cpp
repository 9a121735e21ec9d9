#include "daemon/log/journal.hpp"

#include <bit>
#include <cstdint>

namespace slipd {

static_assert(std::endian::native == std::endian::little, "lengths are copied as they lie in memory");

JournalEntry& JournalEntry::add(std::string_view field, std::string_view value) {
  bytes_ += field;
  if (value.find('\n') == std::string_view::npos) {
    bytes_ += '=';
  } else {
    const std::uint64_t length = value.size();
    bytes_ += '\n';
    bytes_.append(reinterpret_cast<const char*>(&length), sizeof length);
  }
  bytes_ += value;
  bytes_ += '\n';
  return *this;
}

}  // namespace slipd
