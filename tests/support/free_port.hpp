// A TCP port of this computer that no server has now, for servers that a test starts.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>

#include <stdexcept>

#include "core/storage/unique_fd.hpp"

namespace slipd::testing {

inline int free_port() {
  const UniqueFd listener(socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  auto* const any = reinterpret_cast<sockaddr*>(&at);
  if (bind(listener.get(), any, size) != 0 || getsockname(listener.get(), any, &size) != 0)
    throw std::runtime_error("no TCP on this machine");
  return ntohs(at.sin_port);
}

}  // namespace slipd::testing
