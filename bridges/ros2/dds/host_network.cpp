#include "bridges/ros2/dds/host_network.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>

namespace slipd::ros2 {
namespace {

// Cyclone DDS 0.10 uses at most four interfaces.
constexpr std::size_t kMostInterfaces = 4;
// RTPS 2.2, 9.6.1.1: ports of a domain.
constexpr unsigned kFirstPort = 7400, kPortsOfDomain = 250;
constexpr std::string_view kLoopback = "lo";

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// The port of an IPv4 UDP socket; 0: it is something else.
unsigned udp_port(int fd) noexcept {
  int type = 0;
  socklen_t bytes = sizeof type;
  if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &bytes) != 0 || type != SOCK_DGRAM) return 0;
  sockaddr_storage address{};
  bytes = sizeof address;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &bytes) != 0 || address.ss_family != AF_INET)
    return 0;
  return ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

}  // namespace

std::vector<HostInterface> host_interfaces() {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) fail("network interfaces");
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owned(first, freeifaddrs);
  std::vector<HostInterface> found;
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    const bool up = (one->ifa_flags & IFF_UP) != 0;
    if (!up || one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    const auto same = [&](const HostInterface& other) { return other.name == one->ifa_name; };
    if (std::any_of(found.begin(), found.end(), same)) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr, text.data(),
              text.size());
    const bool loopback = (one->ifa_flags & IFF_LOOPBACK) != 0;
    found.insert(loopback ? found.begin() : found.end(), {one->ifa_name, text.data()});
  }
  if (found.size() > kMostInterfaces) found.resize(kMostInterfaces);
  return found;
}

bool receive_from_host_only(unsigned domain) {
  const unsigned first = kFirstPort + kPortsOfDomain * domain;
  bool any = false;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const std::string name = entry.path().filename();
    int fd = -1;
    if (std::from_chars(name.data(), name.data() + name.size(), fd).ec != std::errc()) continue;
    const unsigned port = udp_port(fd);
    if (port < first || port >= first + kPortsOfDomain) continue;
    if (setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, kLoopback.data(), kLoopback.size()) != 0) return false;
    any = true;
  }
  return any;
}

AddressChanges::AddressChanges()
    : fd_(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)) {
  if (fd_ < 0) fail("netlink");
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_IPV4_IFADDR;
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  const int error = errno;
  close(fd_);
  errno = error;
  fail("netlink");
}

AddressChanges::~AddressChanges() {
  close(fd_);
}

void AddressChanges::take() const noexcept {
  std::array<char, 4096> ignored;
  while (recv(fd_, ignored.data(), ignored.size(), MSG_DONTWAIT) > 0 || errno == ENOBUFS) {
  }
}

}  // namespace slipd::ros2
