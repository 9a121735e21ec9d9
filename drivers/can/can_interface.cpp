#include "drivers/can/can_interface.hpp"

#include <linux/can.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace slipd::can {
namespace {

// Whether a filter forbids this process to make CAN sockets. The kernel checks the type before the family, so
// an unknown type gives EINVAL with or without CAN in the kernel. The service manager's filter refuses the
// family before that, with another error.
bool is_forbidden() noexcept {
  constexpr int kNoSuchType = 15;
  const int fd = ::socket(PF_CAN, kNoSuchType | SOCK_CLOEXEC, 0);
  if (fd >= 0) ::close(fd);
  return fd < 0 && errno != EINVAL;
}

}  // namespace

int not_can_error() noexcept {
  return EPROTOTYPE;
}

int check_can_interface(int fd, const std::string& interface) noexcept {
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  if (::ioctl(fd, SIOCGIFHWADDR, &request) != 0) return errno;
  return request.ifr_hwaddr.sa_family == ARPHRD_CAN ? 0 : not_can_error();
}

const char* why_no_can(int error) noexcept {
  switch (error) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case EPERM:
    case EACCES:
      return is_forbidden()
                 ? "the service may not use CAN: install the package slipd-driver-can, which permits it"
                 : "this kernel has no CAN: load its module can-raw";
    case ENODEV:
      return "there is no such interface: plug its adapter in, or correct its name";
    case EPROTOTYPE:
      return "it is no CAN interface: correct its name";
    case EMSGSIZE:
      return "it is not set up for FD frames: set its mtu to 72, or can.fd to false";
    case ENETDOWN:
      return "it is down: configure it and bring it up with ip link set";
    default:
      const char* const text = strerrordesc_np(error);
      return text != nullptr ? text : "an error that the system has no name for";
  }
}

}  // namespace slipd::can
