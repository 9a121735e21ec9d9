#include "daemon/can/socket_port.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "drivers/can/can_interface.hpp"

namespace slipd::can {
namespace {

// SO_SNDBUF for one queued frame: half of what the kernel charges, because it doubles the value.
constexpr std::size_t kBytesAsked = 384;

}  // namespace

int SocketPort::open() noexcept {
  close();
  const int error = set_up();
  if (error != 0) close();
  return error;
}

void SocketPort::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

int SocketPort::set_up() noexcept {
  fd_ = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
  if (fd_ < 0) return errno;
  if (const int error = check_can_interface(fd_, settings_.interface); error != 0) return error;
  ifreq request{};
  std::copy_n(settings_.interface.begin(), std::min<std::size_t>(settings_.interface.size(), IFNAMSIZ - 1),
              request.ifr_name);
  const int on = 1;
  if (settings_.fd) {
    if (ioctl(fd_, SIOCGIFMTU, &request) != 0) return errno;
    if (request.ifr_mtu < static_cast<int>(CANFD_MTU)) return EMSGSIZE;
    if (setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0) return errno;
  }
  if (ioctl(fd_, SIOCGIFINDEX, &request) != 0) return errno;
  // Receives no messages of others, and all error frames of the controller.
  if (setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0) != 0) return errno;
  const can_err_mask_t errors = CAN_ERR_MASK;
  if (setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0) return errno;
  const int room = static_cast<int>(kBytesAsked * messages_);
  if (setsockopt(fd_, SOL_SOCKET, SO_SNDBUF, &room, sizeof room) != 0) return errno;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  const void* const bytes = &address;
  return bind(fd_, static_cast<const sockaddr*>(bytes), sizeof address) == 0 ? 0 : errno;
}

int SocketPort::send(const Message& message) noexcept {
  canfd_frame frame{};
  frame.can_id = message.id | (settings_.extended ? CAN_EFF_FLAG : 0);
  frame.len = message.data.size();
  if (settings_.fd) frame.flags = CANFD_BRS;
  std::copy(message.data.begin(), message.data.end(), frame.data);
  // An FD frame begins like a classic one.
  const std::size_t size = settings_.fd ? CANFD_MTU : CAN_MTU;
  const ssize_t sent = ::send(fd_, &frame, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  return sent == static_cast<ssize_t>(size) ? 0 : errno;
}

bool SocketPort::next_error(BusError& error) noexcept {
  can_frame frame{};
  for (;;) {
    const ssize_t got = recv(fd_, &frame, sizeof frame, MSG_DONTWAIT);
    if (got < 0) return false;  // EAGAIN, or an error that the next send returns too
    if (got != sizeof frame || (frame.can_id & CAN_ERR_FLAG) == 0) continue;
    error.kind = frame.can_id & CAN_ERR_MASK;
    std::copy_n(frame.data, error.data.size(), error.data.begin());
    return true;
  }
}

}  // namespace slipd::can
