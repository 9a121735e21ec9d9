#include "daemon/rt/io_wakeup.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace slipd {

IoWakeup::IoWakeup() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

IoWakeup::~IoWakeup() {
  close(fd_);
}

void IoWakeup::notify() noexcept {
  // Acquire and release: if io has not cleared yet, its clear comes later in this flag's modification order
  // and sees what was written before; if it has, this thread writes the eventfd.
  if (notified_.exchange(true, std::memory_order_acq_rel)) return;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written =
      write(fd_, &one, sizeof one);  // cannot fail: the counter goes to 2^64
}

void IoWakeup::clear() noexcept {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = read(fd_, &count, sizeof count);  // EAGAIN: not notified
  // Acquire: pairs with the release of the last notify(), so that io sees what was written before it.
  // Release: pairs with the acquire of the next notify(), which writes the eventfd again.
  notified_.exchange(false, std::memory_order_acq_rel);
}

}  // namespace slipd
