#include "daemon/log/datagram.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include <cstddef>

#include "core/storage/unique_fd.hpp"

namespace slipd {

namespace {

UniqueFd patient_socket() noexcept {
  constexpr timeval kLongestWait{.tv_sec = 0, .tv_usec = 100'000};
  UniqueFd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &kLongestWait, sizeof kLongestWait);
  return socket;
}

}  // namespace

bool send_datagram(std::string_view address, std::string_view bytes, WhenFull when_full) noexcept {
  static const UniqueFd socket = patient_socket();
  sockaddr_un to{};
  if (address.size() < 2 || address.size() >= sizeof to.sun_path) return false;
  to.sun_family = AF_UNIX;
  address.copy(static_cast<char*>(to.sun_path), address.size());
  if (address.front() == '@') to.sun_path[0] = '\0';
  const int flags = MSG_NOSIGNAL | (when_full == WhenFull::lose ? MSG_DONTWAIT : 0);
  return sendto(socket.get(), bytes.data(), bytes.size(), flags, reinterpret_cast<const sockaddr*>(&to),
                static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size())) >= 0;
}

}  // namespace slipd
