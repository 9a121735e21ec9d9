// A file descriptor that is closed by its destructor. Not thread-safe; any one thread.
#pragma once

#include <unistd.h>

#include <utility>

namespace slipd {

class UniqueFd {
 public:
  // Owns nothing.
  UniqueFd() = default;
  // Owns `fd`; a negative one is none.
  explicit UniqueFd(int fd) noexcept : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~UniqueFd() {
    if (fd_ >= 0) close(fd_);
  }

  // The descriptor, negative if none.
  int get() const noexcept { return fd_; }
  // Gives the descriptor up to the caller.
  int release() noexcept { return std::exchange(fd_, -1); }
  explicit operator bool() const noexcept { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

}  // namespace slipd
