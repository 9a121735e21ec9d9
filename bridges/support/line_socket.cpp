#include "bridges/support/line_socket.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "bridges/support/unix_address.hpp"

namespace slipd::bridges {
namespace {

// Connections that wait to be taken.
constexpr int kWaiting = 16;
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

// False: the other end does not read.
bool send_line(int fd, std::string line) {
  line += '\n';
  return ::send(fd, line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
         static_cast<ssize_t>(line.size());
}

}  // namespace

struct LineSocket::Peer {
  explicit Peer(int socket) : fd(socket) {}
  ~Peer() {
    watch = {};
    ::close(fd);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  int fd;
  std::string heard;
  Loop::Watch watch;
};

LineSocket::LineSocket(Loop& loop, const std::string& path, Answer answer, LineSocketOptions options)
    : loop_(loop), path_(path), answer_(std::move(answer)), options_(std::move(options)) {
  const sockaddr_un address = address_of(path);
  if (const int other = connected_to(address); other >= 0) {
    ::close(other);
    fail(path, "another program listens there: end it, or choose another path");
  }
  if (errno == ECONNREFUSED) ::unlink(path.c_str());
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ < 0 || ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::chmod(path.c_str(), kMode) != 0 || ::listen(listener_, kWaiting) != 0) {
    const std::string why = std::generic_category().message(errno);
    ::close(listener_);
    fail(path, "cannot listen there: " + why + "; its folder must exist and be writable");
  }
  watch_ = {loop, listener_, EPOLLIN, [this](std::uint32_t) { admit(); }};
}

LineSocket::~LineSocket() {
  watch_ = {};
  peers_.clear();
  ::close(listener_);
  ::unlink(path_.c_str());
}

void LineSocket::admit() {
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  if (peers_.size() >= options_.most_peers) {
    if (!options_.refusal.empty()) {
      send_line(fd, options_.refusal);
      ::close(fd);
      return;
    }
    peers_.pop_front();
  }
  Peer& peer = peers_.emplace_back(fd);
  peer.watch = {loop_, fd, EPOLLIN, [this, &peer](std::uint32_t) { hear(peer); }};
}

void LineSocket::hear(Peer& peer) {
  char bytes[512];
  const ssize_t got = ::recv(peer.fd, bytes, sizeof bytes, 0);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (got > 0) peer.heard.append(bytes, static_cast<std::size_t>(got));
  if (got > 0 && serve(peer)) return;
  peers_.remove_if([&peer](const Peer& one) { return &one == &peer; });
}

// Answers the lines that are whole. False: the other end talks too much or does not read.
bool LineSocket::serve(Peer& peer) {
  for (std::size_t end = 0; (end = peer.heard.find('\n')) != std::string::npos;) {
    if (end > options_.longest_line || !send_line(peer.fd, answer_(peer.heard.substr(0, end)))) return false;
    peer.heard.erase(0, end + 1);
  }
  return peer.heard.size() <= options_.longest_line;
}

std::string ask(const std::string& path, const std::string& line) {
  const int fd = connected_to(address_of(path));
  if (fd < 0) fail(path, "no program listens there: " + std::generic_category().message(errno));
  const timeval patience{kAnswerTimeoutS, 0};
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  send_line(fd, line);
  std::string answer;
  char bytes[1024];
  while (!answer.ends_with('\n')) {
    const ssize_t got = ::recv(fd, bytes, sizeof bytes, 0);
    if (got <= 0) break;
    answer.append(bytes, static_cast<std::size_t>(got));
  }
  ::close(fd);
  if (!answer.ends_with('\n')) fail(path, "the program there did not answer; look at its journal");
  answer.pop_back();
  return answer;
}

}  // namespace slipd::bridges
