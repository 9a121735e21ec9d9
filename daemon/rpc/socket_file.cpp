#include "daemon/rpc/socket_file.hpp"

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

}  // namespace

SocketFile::SocketFile(std::filesystem::path path, unsigned mode)
    : path_(std::move(path)), lock_path_(path_.string() + ".lock") {
  try {
    lock();
    bind_and_listen(mode);
  } catch (...) {
    if (listener_ >= 0) close(listener_);
    if (lock_fd_ >= 0) close(lock_fd_);
    throw;
  }
}

SocketFile::SocketFile(int listener) : listener_(listener) {
  sockaddr_un address{};
  socklen_t length = sizeof address;
  if (getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) == 0) path_ = address.sun_path;
}

SocketFile::~SocketFile() {
  close(listener_);
  if (lock_fd_ < 0) return;
  unlink(path_.c_str());
  unlink(
      lock_path_.c_str());  // while it is locked: a process that opened it before sees that it was replaced
  close(lock_fd_);
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
      throw std::runtime_error(path_.string() + " is served by " + holder(lock_fd_) +
                               " already; stop it, or give this one another socket.path");
    }
    struct stat held {};
    struct stat named {};
    if (fstat(lock_fd_, &held) == 0 && stat(lock_path_.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
        held.st_dev == named.st_dev) {
      break;
    }
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
    unlink(path_.c_str());  // this process holds the lock, so no other serves it
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
  if (chmod(path_.c_str(), mode) != 0) fail("cannot set the mode of " + path_.string(), errno, "");
  if (listen(listener_, SOMAXCONN) != 0) fail("cannot listen on " + path_.string(), errno, "");
}

int SocketFile::duplicate() const {
  const int fd = fcntl(listener_, F_DUPFD_CLOEXEC, 0);
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "the listening socket");
  return fd;
}

}  // namespace slipd
