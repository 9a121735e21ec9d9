#include "daemon/log/datagram.hpp"

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>

#include "core/storage/unique_fd.hpp"

namespace slipd {

void send_datagram(std::string_view address, std::string_view bytes) noexcept {
  static const UniqueFd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un to{};
  if (address.size() < 2 || address.size() >= sizeof to.sun_path) return;
  to.sun_family = AF_UNIX;
  address.copy(static_cast<char*>(to.sun_path), address.size());
  if (address.front() == '@') to.sun_path[0] = '\0';
  sendto(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to),
         static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size()));
}

}  // namespace slipd
