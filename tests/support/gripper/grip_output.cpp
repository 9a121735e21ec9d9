#include "tests/support/gripper/grip_output.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>

namespace slipd::gripper {

GripOutput::GripOutput(const std::string& grip_input) : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  grip_input.copy(address.sun_path, sizeof address.sun_path - 1);
  const void* const bytes = &address;
  if (::connect(fd_, static_cast<const sockaddr*>(bytes), sizeof address) == 0) return;
  const int cause = errno;
  ::close(fd_);
  throw std::system_error(cause, std::generic_category(), grip_input);
}

GripOutput::~GripOutput() {
  ::close(fd_);
}

bool GripOutput::press(double force_n) const noexcept {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), force_n, std::chars_format::fixed, 4).ptr;
  return ::send(fd_, text.data(), static_cast<std::size_t>(end - text.data()), MSG_DONTWAIT | MSG_NOSIGNAL) >=
             0 ||
         errno == EAGAIN;
}

}  // namespace slipd::gripper
