#include "daemon/rpc/clients/socket_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "core/storage/descriptor_passing.hpp"
#include "core/storage/unique_fd.hpp"

namespace slipd {
namespace {

[[noreturn]] void fail(const std::string& what, int error, const std::string& remedy) {
  throw std::runtime_error(what + ": " + std::generic_category().message(error) +
                           (remedy.empty() ? "" : "; " + remedy));
}

std::string holder(int fd) {
  std::array<char, 32> text{};
  const auto length = pread(fd, text.data(), text.size() - 1, 0);
  std::string pid(text.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  while (!pid.empty() && pid.back() == '\n') pid.pop_back();
  return pid.empty() ? "another slipd" : "another slipd (process " + pid + ")";
}

// "slipd (process 12)" of the process that listens, as far as the kernel says.
std::string listener_of(int connected) {
  ucred who{};
  socklen_t length = sizeof who;
  if (getsockopt(connected, SOL_SOCKET, SO_PEERCRED, &who, &length) != 0 || who.pid <= 0)
    return "another program";
  return "another program (process " + std::to_string(who.pid) + ")";
}

// Throws unless the socket at `address` is one that nobody listens on, as a crash leaves it.
void require_dead_socket(const sockaddr_un& address) {
  const std::string path = address.sun_path;
  const UniqueFd probe(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!probe) fail("cannot make a socket", errno, "");
  if (connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    throw std::runtime_error(path + " is served by " + listener_of(probe.get()) +
                             " already; stop it, or choose another socket.path");
  }
  if (errno == ECONNREFUSED || errno == ENOENT) return;
  if (errno == EAGAIN || errno == EPROTOTYPE) {  // its queue is full, or it is no stream socket
    throw std::runtime_error(path + " is in use by another program; stop it, or choose another socket.path");
  }
  fail("cannot tell whether " + path + " is in use", errno, "remove it, or choose another socket.path");
}

}  // namespace

SocketFile::SocketFile(std::filesystem::path path, unsigned mode)
    : path_(std::move(path)), lock_path_(path_.string() + ".lock") {
  try {
    lock();
    bind_and_listen(mode);
  } catch (...) {
    if (lock_fd_ >= 0) remove_own_files();
    if (listener_ >= 0) close(listener_);
    if (lock_fd_ >= 0) close(lock_fd_);
    throw;
  }
}

SocketFile::SocketFile(int listener) : listener_(listener) {
  refuse_descriptors(listener_);  // clients that connected before may still pass them
  sockaddr_un address{};
  socklen_t length = sizeof address;
  if (getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) == 0) path_ = address.sun_path;
}

SocketFile::~SocketFile() {
  if (lock_fd_ >= 0) remove_own_files();
  // listener_ stays open: connections that wait in it may bear descriptors, whose close a client can hold up
  // as long as it wants (socket_closer.hpp). The end of the process closes it, and waits for nothing.
  if (lock_fd_ >= 0) close(lock_fd_);
}

std::optional<SocketFile::Identity> SocketFile::identity_of(const std::filesystem::path& path) {
  struct stat there {};
  if (lstat(path.c_str(), &there) != 0) return std::nullopt;
  return Identity{there.st_dev, there.st_ino};
}

// While the listener is open and the lock is held: the kernel cannot give their inodes to other files, and a
// process that opened the lock before sees that it was replaced.
void SocketFile::remove_own_files() const {
  if (made_ && identity_of(path_) == made_) unlink(path_.c_str());
  struct stat held {};
  if (fstat(lock_fd_, &held) == 0 && identity_of(lock_path_) == Identity{held.st_dev, held.st_ino})
    unlink(lock_path_.c_str());
}

void SocketFile::lock() {
  for (;;) {
    lock_fd_ = open(lock_path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (lock_fd_ < 0) {
      fail("cannot open " + lock_path_.string(), errno,
           "let socket.path lie in a folder that slipd may write to");
    }
    if (flock(lock_fd_, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) fail("cannot lock " + lock_path_.string(), errno, "");
      const std::string by = holder(lock_fd_);
      close(std::exchange(lock_fd_, -1));  // it is not this one's to remove
      throw std::runtime_error(path_.string() + " is served by " + by +
                               " already; stop it, or give this one another socket.path");
    }
    struct stat held {};
    if (fstat(lock_fd_, &held) == 0 && identity_of(lock_path_) == Identity{held.st_dev, held.st_ino}) break;
    close(lock_fd_);  // its last holder removed it between open and lock
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(lock_fd_, 0) != 0 || pwrite(lock_fd_, pid.data(), pid.size(), 0) < 0) {
    fail("cannot write " + lock_path_.string(), errno, "");
  }
}

void SocketFile::bind_and_listen(unsigned mode) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path_.native().size() >= sizeof address.sun_path) {
    throw std::runtime_error("socket.path " + path_.string() + " is longer than the " +
                             std::to_string(sizeof address.sun_path - 1) +
                             " bytes that a Unix socket may have");
  }
  std::memcpy(address.sun_path, path_.c_str(), path_.native().size() + 1);
  struct stat there {};
  if (lstat(path_.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode)) {
      throw std::runtime_error(path_.string() +
                               " exists and is no socket; remove it, or choose another socket.path");
    }
    require_dead_socket(address);
    unlink(path_.c_str());
  }
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ < 0) fail("cannot make a socket", errno, "");
  // Accessible to slipd's user only at first; chmod sets the configured permissions when it listens.
  const mode_t before = umask(0177);
  const int bound = bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int error = errno;
  umask(before);
  if (bound != 0)
    fail("cannot bind " + path_.string(), error, "does its folder exist and may slipd write to it?");
  made_ = identity_of(path_);
  refuse_descriptors(listener_);
  if (chmod(path_.c_str(), mode) != 0) fail("cannot set the mode of " + path_.string(), errno, "");
  if (listen(listener_, SOMAXCONN) != 0) fail("cannot listen on " + path_.string(), errno, "");
}

int SocketFile::duplicate() const {
  const int fd = fcntl(listener_, F_DUPFD_CLOEXEC, 0);
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "the listening socket");
  return fd;
}

}  // namespace slipd
