#include "daemon/log/journal.hpp"

#include <sys/socket.h>
#include <sys/un.h>

#include <cstdint>

#include "core/storage/unique_fd.hpp"

namespace slipd {
namespace {

constexpr const char* kJournald = "/run/systemd/journal/socket";

// 64 bit, the lowest byte first.
std::string little_endian(std::uint64_t value) {
  constexpr unsigned kByteBits = 8;
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i)
    bytes += static_cast<char>((value >> (kByteBits * i)) & 0xFFU);
  return bytes;
}

}  // namespace

JournalEntry& JournalEntry::add(std::string_view field, std::string_view value) {
  bytes_ += field;
  if (value.find('\n') == std::string_view::npos) {
    bytes_ += '=';
  } else {
    bytes_ += '\n';
    bytes_ += little_endian(value.size());
  }
  bytes_ += value;
  bytes_ += '\n';
  return *this;
}

void send_to_journal(const JournalEntry& entry) noexcept {
  static const UniqueFd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::string_view(kJournald).copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
  sendto(socket.get(), entry.bytes().data(), entry.bytes().size(), MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

}  // namespace slipd
