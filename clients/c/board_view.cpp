#include "clients/c/board_view.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>

namespace slipd::client {

using board_layout::Header;
using board_layout::Record;
using board_layout::Slot;

std::string BoardView::map(const UniqueFd& file) {
  unmap();
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) return std::generic_category().message(errno);
  const auto bytes = static_cast<std::size_t>(facts.st_size);
  // A file that could shrink would end this program with SIGBUS.
  const int seals = fcntl(file.get(), F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0 || bytes < sizeof(Header))
    return "what was passed is not the board of a slipd";
  void* const mapped = mmap(nullptr, bytes, PROT_READ, MAP_SHARED | MAP_POPULATE, file.get(), 0);
  if (mapped == MAP_FAILED) return std::generic_category().message(errno);
  memory_ = static_cast<const std::byte*>(mapped);
  bytes_ = bytes;
  const Header& head = header();
  const bool known = head.magic == board_layout::kMagic && head.version == board_layout::kVersion &&
                     head.header_bytes == sizeof(Header) && head.slot_bytes == sizeof(Slot) &&
                     head.record_bytes == sizeof(Record) &&
                     board_layout::bytes_for(head.sensors, head.grasps) <= bytes;
  if (!known) {
    unmap();
    return "the board of this slipd is of another version; upgrade libslipd0 and slipd together";
  }
  slots_ = std::size_t{head.sensors} + head.grasps;
  return {};
}

void BoardView::unmap() noexcept {
  if (memory_ != nullptr) munmap(const_cast<std::byte*>(memory_), bytes_);
  memory_ = nullptr;
  slots_ = 0;
}

int BoardView::find(const char* name) const noexcept {
  for (std::size_t i = 0; i < slots_; ++i) {
    const Slot& slot = at(static_cast<int>(i));
    if (std::strncmp(slot.name.data(), name, slot.name.size()) == 0) return static_cast<int>(i);
  }
  return -1;
}

void BoardView::wait(int slot, std::uint32_t seen, std::int64_t until_ns) const noexcept {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const timespec until{until_ns / kSecond, until_ns % kSecond};
  // The kernel reads the word only, so it may lie in read-only memory. Not FUTEX_PRIVATE: slipd wakes it.
  const auto waited = syscall(SYS_futex, &at(slot).published, FUTEX_WAIT_BITSET, seen, &until, nullptr,
                              FUTEX_BITSET_MATCH_ANY);
  if (waited == 0 || errno == EAGAIN || errno == EINTR || errno == ETIMEDOUT) return;
  const timespec pause{0, 1'000'000};  // a sandbox without futexes: look a thousand times a second
  nanosleep(&pause, nullptr);
}

}  // namespace slipd::client
