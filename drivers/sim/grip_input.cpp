#include "drivers/sim/grip_input.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "driver_api/driver.hpp"

namespace slipd::sim {
namespace {

constexpr int kMostAtOnce = 64;  // datagrams per call, so that a flood of them cannot delay frames

void skip_blanks(std::string_view& s) noexcept {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t' || s.front() == '\n' || s.front() == '\r')) {
    s.remove_prefix(1);
  }
}

bool take(std::string_view& s, std::string_view expected) noexcept {
  skip_blanks(s);
  if (s.substr(0, expected.size()) != expected) return false;
  s.remove_prefix(expected.size());
  return true;
}

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    throw DriverError(path + ": grip_input: a socket's path has at most 107 bytes");
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

// Removes a socket file that refuses connections because its owner has ended. Leaves any other file.
void remove_stale(const std::string& path, const sockaddr_un& address) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return;
  const int probe = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return;
  const bool refused = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
                       errno == ECONNREFUSED;
  ::close(probe);
  if (refused) ::unlink(path.c_str());
}

}  // namespace

std::optional<double> parse_grip(std::string_view datagram) noexcept {
  skip_blanks(datagram);
  const bool object = take(datagram, "{");
  if (object && !(take(datagram, "\"normal_n\"") && take(datagram, ":"))) return std::nullopt;
  skip_blanks(datagram);
  double normal_n = 0;
  const auto [end, error] = std::from_chars(datagram.data(), datagram.data() + datagram.size(), normal_n);
  if (error != std::errc()) return std::nullopt;
  datagram.remove_prefix(static_cast<std::size_t>(end - datagram.data()));
  if (object && !take(datagram, "}")) return std::nullopt;
  skip_blanks(datagram);
  if (!datagram.empty() || !std::isfinite(normal_n) || normal_n < 0) return std::nullopt;
  return normal_n;
}

GripInput::GripInput(std::string path) : path_(std::move(path)), fd_(-1) {
  const auto address = address_of(path_);
  remove_stale(path_, address);
  fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0 || ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int cause = errno;
    if (fd_ >= 0) ::close(fd_);
    throw DriverError(path_ +
                      ": grip_input: cannot make the socket: " + std::generic_category().message(cause) +
                      ": name a path in a folder that slipd may write to, and that nobody else uses");
  }
}

GripInput::~GripInput() {
  ::close(fd_);
  ::unlink(path_.c_str());
}

std::optional<double> GripInput::newest() noexcept {
  std::optional<double> newest;
  char datagram[256];
  for (int i = 0; i < kMostAtOnce; ++i) {
    const auto size = ::recv(fd_, datagram, sizeof datagram, MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0) break;
    if (static_cast<std::size_t>(size) > sizeof datagram) continue;
    if (const auto normal_n = parse_grip({datagram, static_cast<std::size_t>(size)})) newest = normal_n;
  }
  return newest;
}

}  // namespace slipd::sim
