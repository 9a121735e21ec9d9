// Wakes a loop from another thread: a Loop::Watch of fd() sees the bell when it was rung.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace slipd::bridges {

class Bell {
 public:
  // Throws std::system_error.
  Bell() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  }
  ~Bell() { close(fd_); }
  Bell(const Bell&) = delete;
  Bell& operator=(const Bell&) = delete;

  // An eventfd, readable from ring() to hear().
  int fd() const noexcept { return fd_; }
  // Any thread.
  void ring() const noexcept { eventfd_write(fd_, 1); }
  // The loop's thread.
  void hear() const noexcept {
    eventfd_t ignored = 0;
    eventfd_read(fd_, &ignored);
  }

 private:
  int fd_;
};

}  // namespace slipd::bridges
