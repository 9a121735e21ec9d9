#include "drivers/modbus/unreachable.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <memory>
#include <system_error>

#include "core/storage/unique_fd.hpp"

namespace slipd::modbus {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

// Null: the name has no address, or cannot be resolved.
Addresses addresses_of(const std::string& host) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), "9", &wanted, &found) != 0) found = nullptr;
  return {found, freeaddrinfo};
}

std::string text_of(const addrinfo& address) {
  std::array<char, NI_MAXHOST> text{};
  const int error =
      getnameinfo(address.ai_addr, address.ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST);
  return error == 0 ? text.data() : "";
}

// Whether the system forbids this process to send to the address. The service manager's filter drops the
// packets of a TCP connection without an error, so that connecting times out; a datagram fails with EPERM.
// The datagram is empty and goes to the discard port.
bool is_forbidden(const addrinfo& address) {
  const UniqueFd probe(socket(address.ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!probe) return errno == EAFNOSUPPORT || errno == EPERM;
  return sendto(probe.get(), "", 0, MSG_NOSIGNAL, address.ai_addr, address.ai_addrlen) < 0 && errno == EPERM;
}

}  // namespace

std::string why_unreachable(const std::string& host, int port, int error) {
  const Addresses addresses = addresses_of(host);
  if (!addresses)
    return "its name cannot be resolved: give its numeric address as device.host, since the service may be "
           "kept "
           "from asking a name server";
  for (const addrinfo* each = addresses.get(); each != nullptr; each = each->ai_next) {
    if (!is_forbidden(*each)) continue;
    return "the service may not reach it: run systemctl edit slipd, write the lines [Service] and "
           "IPAddressAllow=" +
           text_of(*each) + ", then systemctl restart slipd";
  }
  switch (error) {
    case EINPROGRESS:
    case ETIMEDOUT:
      return "no answer within a second: is the device on, and on this network?";
    case ECONNREFUSED:
      return "nothing listens at its port " + std::to_string(port) +
             ": is the device on, and device.port right?";
    default:
      return std::generic_category().message(error) + ": is the device on and its network reachable?";
  }
}

}  // namespace slipd::modbus
