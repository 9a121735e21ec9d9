#include "core/storage/bounded_output.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>

namespace slipd {
namespace {

using OutputClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kHurriedStall{50};
constexpr int kPollMs = 20;  // between two looks at OutputPatience::hurry
constexpr std::size_t kFilePiece = std::size_t{1} << 20;

// Bytes written, or negative with errno.
ssize_t write_piece(int fd, OutputKind kind, std::span<const std::uint8_t> bytes) noexcept {
  switch (kind) {
    case OutputKind::regular_file:
      return ::write(fd, bytes.data(), std::min(bytes.size(), kFilePiece));
    case OutputKind::socket:
      return ::send(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    case OutputKind::pipe:
    case OutputKind::other:
      break;
  }
  return ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), PIPE_BUF));
}

// Whether a write would be taken now, after at most `timeout_ms`. Errors count as writable: the write tells
// which it is.
bool writable(int fd, int timeout_ms) noexcept {
  pollfd wait{fd, POLLOUT, 0};
  return ::poll(&wait, 1, timeout_ms) > 0;
}

}  // namespace

OutputKind kind_of_output(int fd) noexcept {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return OutputKind::other;
  if (S_ISREG(status.st_mode)) return OutputKind::regular_file;
  if (S_ISFIFO(status.st_mode)) return OutputKind::pipe;
  return S_ISSOCK(status.st_mode) ? OutputKind::socket : OutputKind::other;
}

std::error_code write_bounded(int fd, OutputKind kind, std::span<const std::uint8_t> bytes,
                              const OutputPatience& patience) noexcept {
  auto last_taken = OutputClock::now();
  while (!bytes.empty()) {
    if (kind == OutputKind::regular_file || writable(fd, kPollMs)) {
      const ssize_t taken = write_piece(fd, kind, bytes);
      if (taken > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(taken));
        last_taken = OutputClock::now();
        continue;
      }
      if (taken < 0 && errno != EAGAIN && errno != EINTR) return {errno, std::generic_category()};
    }
    const bool hurried = patience.hurry != nullptr && patience.hurry->load(std::memory_order_relaxed);
    const auto allowed = hurried ? std::min(patience.stalled, kHurriedStall) : patience.stalled;
    if (OutputClock::now() - last_taken >= allowed) return std::make_error_code(std::errc::timed_out);
  }
  return {};
}

}  // namespace slipd
