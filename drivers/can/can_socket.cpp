#include "drivers/can/can_socket.hpp"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "driver_api/driver.hpp"
#include "drivers/can/can_interface.hpp"
#include "drivers/pacing.hpp"

namespace slipd::can {
namespace {

// A scan of many boards comes in one burst; the kernel's default holds a few hundred frames only.
constexpr int kReceiveBytes = 1 << 20;
constexpr std::int64_t kOldestNs = 1'000'000'000;  // an older time stamp means that the wall clock was set

[[noreturn]] void fail(const std::string& interface, const std::string& what, const std::string& remedy) {
  throw DriverError("CAN interface " + interface + ": " + what + ": " +
                    std::generic_category().message(errno) + "; " + remedy);
}

[[noreturn]] void unusable(const std::string& interface, int error) {
  throw DriverError("CAN interface " + interface + ": " + why_no_can(error));
}

std::uint32_t wire_id(std::uint32_t id) {
  return id > CAN_SFF_MASK ? id | CAN_EFF_FLAG : id;
}

template <class Value>
void set(int fd, int level, int option, const Value& value, const std::string& interface) {
  if (::setsockopt(fd, level, option, &value, sizeof value) != 0)
    fail(interface, "socket option " + std::to_string(option), "is the kernel older than 4.14?");
}

void filter(int fd, const std::vector<std::uint32_t>& ids, const std::string& interface) {
  std::vector<can_filter> filters;
  for (const std::uint32_t id : ids) {
    const canid_t mask = CAN_EFF_FLAG | CAN_RTR_FLAG | (id > CAN_SFF_MASK ? CAN_EFF_MASK : CAN_SFF_MASK);
    filters.push_back({wire_id(id), mask});
  }
  if (filters.size() > CAN_RAW_FILTER_MAX) return;  // without filters the decoder ignores foreign ids
  if (::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(filters.size() * sizeof(can_filter))) != 0) {
    fail(interface, "filters", "report this");
  }
}

// The kernel stamps with the wall clock; this converts a stamp to CLOCK_MONOTONIC.
std::int64_t monotonic_of(const timespec& stamp) noexcept {
  timespec wall{};
  ::clock_gettime(CLOCK_REALTIME, &wall);
  const std::int64_t age_ns =
      (std::int64_t{wall.tv_sec} - stamp.tv_sec) * 1'000'000'000 + (wall.tv_nsec - stamp.tv_nsec);
  const std::int64_t now_ns = monotonic_ns();
  return age_ns < 0 || age_ns > kOldestNs ? now_ns : now_ns - age_ns;
}

}  // namespace

Socket::Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

Socket& Socket::operator=(Socket&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Socket::~Socket() {
  close();
}

void Socket::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

ReceiveResult Socket::receive(ReceivedFrame& out, std::int64_t give_up_ns) noexcept {
  for (;;) {
    iovec data{&out.frame, sizeof out.frame};
    alignas(cmsghdr) std::array<char, 128> control{};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(fd_, &message, MSG_DONTWAIT);
    if (size == CAN_MTU || size == CANFD_MTU) {
      out.time_ns = 0;
      for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
        if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
        out.time_ns = monotonic_of(stamp);
      }
      if (out.time_ns == 0) out.time_ns = monotonic_ns();
      const std::size_t most = size == CAN_MTU ? CAN_MAX_DLEN : CANFD_MAX_DLEN;
      out.frame.len = static_cast<std::uint8_t>(std::min<std::size_t>(out.frame.len, most));
      return ReceiveResult::frame;
    }
    if (size >= 0) return ReceiveResult::disconnected;  // a size that no CAN socket returns
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return ReceiveResult::disconnected;
    const std::int64_t left_ns = give_up_ns - monotonic_ns();
    if (left_ns <= 0) return ReceiveResult::timeout;
    const timespec wait{static_cast<time_t>(left_ns / 1'000'000'000),
                        static_cast<long>(left_ns % 1'000'000'000)};
    pollfd readable{fd_, POLLIN, 0};
    const int ready = ::ppoll(&readable, 1, &wait, nullptr);
    if (ready == 0) return ReceiveResult::timeout;
    if (ready < 0 && errno != EINTR) return ReceiveResult::disconnected;
  }
}

bool Socket::send(std::uint32_t id, std::span<const std::uint8_t> bytes) noexcept {
  canfd_frame frame{};
  frame.can_id = wire_id(id);
  frame.len = static_cast<std::uint8_t>(std::min<std::size_t>(bytes.size(), CANFD_MAX_DLEN));
  std::copy_n(bytes.begin(), frame.len, frame.data);
  const std::size_t size = frame.len > CAN_MAX_DLEN ? CANFD_MTU : CAN_MTU;
  return ::send(fd_, &frame, size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

Socket open_interface(const std::string& interface, const std::vector<std::uint32_t>& ids) {
  const int fd = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (fd < 0) unusable(interface, errno);
  Socket socket(fd);
  if (const int error = check_can_interface(fd, interface); error != 0) unusable(interface, error);
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  if (::ioctl(fd, SIOCGIFINDEX, &request) != 0) unusable(interface, errno);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  if (::ioctl(fd, SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0)
    unusable(interface, ENETDOWN);
  filter(fd, ids, interface);
  set(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}, interface);
  set(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, int{1}, interface);
  set(fd, SOL_SOCKET, SO_TIMESTAMPNS, int{1}, interface);
  // With CAP_NET_ADMIN beyond the system's limit, else up to it.
  if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &kReceiveBytes, sizeof kReceiveBytes) != 0)
    set(fd, SOL_SOCKET, SO_RCVBUF, kReceiveBytes, interface);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    fail(interface, "cannot be listened to", "is it still there?");
  return socket;
}

}  // namespace slipd::can
