#include "grip/order_socket.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "grip/unix_address.hpp"

namespace slipd::grip {
namespace {

// Longest line that is heard, bytes; and connections at once.
constexpr std::size_t kLongestOrder = 64;
constexpr std::size_t kMostPeers = 16;
// Who asks waits no longer, s.
constexpr time_t kAnswerTimeoutS = 5;
constexpr mode_t kMode = 0660;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

sockaddr_un address_of(const std::string& path) {
  const auto address = unix_address(path);
  if (!address) fail(path, "is too long for a socket: 107 bytes at most");
  return *address;
}

// -1 with errno.
int connected_to(const sockaddr_un& address) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0 || ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

}  // namespace

struct OrderSocket::Peer {
  explicit Peer(int socket) : fd(socket) {}
  ~Peer() {
    watch = {};
    ::close(fd);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  int fd;
  std::string line;
  bridges::Loop::Watch watch;
};

OrderSocket::OrderSocket(bridges::Loop& loop, const std::string& path, Answer answer)
    : loop_(loop), path_(path), answer_(std::move(answer)) {
  const sockaddr_un address = address_of(path);
  if (const int other = connected_to(address); other >= 0) {
    ::close(other);
    fail(path, "another slipd-grip takes orders there: end it, or choose another path in \"orders\"");
  }
  if (errno == ECONNREFUSED) ::unlink(path.c_str());
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ < 0 || ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::chmod(path.c_str(), kMode) != 0 || ::listen(listener_, static_cast<int>(kMostPeers)) != 0) {
    const std::string why = std::generic_category().message(errno);
    ::close(listener_);
    fail(path, "cannot take orders there: " + why + "; its folder must exist and be writable");
  }
  watch_ = {loop, listener_, EPOLLIN, [this](std::uint32_t) { admit(); }};
}

OrderSocket::~OrderSocket() {
  watch_ = {};
  peers_.clear();
  ::close(listener_);
  ::unlink(path_.c_str());
}

void OrderSocket::admit() {
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  if (peers_.size() >= kMostPeers) peers_.pop_front();  // one that says nothing gives way
  Peer& peer = peers_.emplace_back(fd);
  peer.watch = {loop_, fd, EPOLLIN, [this, &peer](std::uint32_t) { hear(peer); }};
}

void OrderSocket::hear(Peer& peer) {
  char bytes[kLongestOrder];
  const ssize_t got = ::recv(peer.fd, bytes, sizeof bytes, 0);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (got > 0) peer.line.append(bytes, static_cast<std::size_t>(got));
  const auto end = peer.line.find('\n');
  if (got > 0 && end == std::string::npos && peer.line.size() < kLongestOrder) return;
  if (end != std::string::npos) {
    const std::string answer = answer_(peer.line.substr(0, end)) + "\n";
    (void)::send(peer.fd, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  peers_.remove_if([&peer](const Peer& one) { return &one == &peer; });
}

std::string ask(const std::string& path, const std::string& line) {
  const int fd = connected_to(address_of(path));
  if (fd < 0) fail(path, "no slipd-grip takes orders there: " + std::generic_category().message(errno));
  const timeval patience{kAnswerTimeoutS, 0};
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  const std::string sent = line + "\n";
  (void)::send(fd, sent.data(), sent.size(), MSG_NOSIGNAL);
  std::string answer;
  char bytes[1024];
  for (ssize_t got = 0; (got = ::recv(fd, bytes, sizeof bytes, 0)) > 0;)
    answer.append(bytes, static_cast<std::size_t>(got));
  ::close(fd);
  if (!answer.ends_with('\n')) fail(path, "slipd-grip did not answer; look at its journal");
  answer.pop_back();
  return answer;
}

}  // namespace slipd::grip
