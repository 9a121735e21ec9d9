#include "daemon/rt/wake.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace slipd {

Wake::Wake() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

Wake::~Wake() {
  close(fd_);
}

void Wake::ring() noexcept {
  // Acquire and release: if io has not cleared yet, its clear comes later in this flag's order and sees our
  // news; if it has, we write.
  if (rung_.exchange(true, std::memory_order_acq_rel)) return;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(fd_, &one, sizeof one);  // cannot fail: it counts to 2^64
}

void Wake::clear() noexcept {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = read(fd_, &count, sizeof count);  // EAGAIN: nobody rang
  // Acquire: pairs with the release of the last ring(), whose news io looks for next. Release: with the
  // acquire of the next one, which writes again.
  rung_.exchange(false, std::memory_order_acq_rel);
}

}  // namespace slipd
