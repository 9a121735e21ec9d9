#include "core/storage/bounded_output.hpp"

#include <linux/sockios.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <thread>
#include <utility>

namespace slipd {
namespace {

using OutputClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{5};  // between two looks at the reader and at OutputPatience
// What one send hands over. The kernel keeps so little in one piece of memory, which splice(2) copies; of
// more, the reader's pipes would hold pages that count as slipd's.
constexpr std::size_t kSocketPiece = 3072;
constexpr std::size_t kFilePiece = std::size_t{1} << 20;

// Tells when the patience of one call is over.
class Waiting {
 public:
  explicit Waiting(const OutputPatience& patience) noexcept : patience_(patience) {}
  void progress() noexcept { last_ = OutputClock::now(); }
  bool over() const noexcept {
    const auto now = OutputClock::now();
    if (now - last_ >= patience_.stalled) return true;
    return patience_.until_ns != nullptr &&
           now.time_since_epoch() >=
               std::chrono::nanoseconds(patience_.until_ns->load(std::memory_order_relaxed));
  }

 private:
  const OutputPatience& patience_;
  OutputClock::time_point last_ = OutputClock::now();
};

}  // namespace

std::error_code write_file(int fd, std::span<const std::uint8_t> bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t taken = ::write(fd, bytes.data(), std::min(bytes.size(), kFilePiece));
    if (taken > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(taken));
    } else if (taken < 0 && errno != EINTR) {
      return {errno, std::generic_category()};
    }
  }
  return {};
}

std::error_code send_bounded(int socket, std::span<const std::uint8_t> bytes,
                             const OutputPatience& patience) noexcept {
  Waiting waiting(patience);
  while (!bytes.empty()) {
    const ssize_t taken =
        ::send(socket, bytes.data(), std::min(bytes.size(), kSocketPiece), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (taken > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(taken));
      waiting.progress();
    } else if (taken < 0 && errno == EAGAIN) {
      pollfd room{socket, POLLOUT, 0};
      ::poll(&room, 1, static_cast<int>(kLook.count()));
    } else if (taken < 0 && errno != EINTR) {
      return {errno, std::generic_category()};
    }
    if (!bytes.empty() && waiting.over()) return std::make_error_code(std::errc::timed_out);
  }
  return {};
}

std::error_code await_read(int socket, const OutputPatience& patience) noexcept {
  Waiting waiting(patience);
  for (std::size_t before = unread_bytes(socket); before > 0;) {
    if (waiting.over()) return std::make_error_code(std::errc::timed_out);
    std::this_thread::sleep_for(kLook);
    const std::size_t left = unread_bytes(socket);
    if (left < std::exchange(before, left)) waiting.progress();
  }
  pollfd ended{socket, 0, 0};  // an error: the reader has closed with bytes unread
  if (::poll(&ended, 1, 0) == 1 && (ended.revents & POLLERR) != 0)
    return std::make_error_code(std::errc::connection_reset);
  return {};
}

std::error_code await_hang_up(int socket, std::chrono::milliseconds time) noexcept {
  pollfd ended{socket, 0, 0};
  if (::poll(&ended, 1, static_cast<int>(time.count())) != 1) return {};
  return std::make_error_code(std::errc::connection_reset);
}

std::size_t unread_bytes(int socket) noexcept {
  int bytes = 0;
  return ::ioctl(socket, SIOCOUTQ, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

}  // namespace slipd
