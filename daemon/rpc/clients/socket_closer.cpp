#include "daemon/rpc/clients/socket_closer.hpp"

#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <exception>

#include "core/storage/descriptor_passing.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {
namespace {

constexpr int kMostThreads = 16;
constexpr std::size_t kStackBytes = std::size_t{64} * 1024;

// Whether the client has sent anything that was not read. Nothing comes any more after a shutdown.
bool has_unread(int socket) noexcept {
  int bytes = 0;
  return ioctl(socket, FIONREAD, &bytes) != 0 || bytes > 0;
}

}  // namespace

bool SocketCloser::close(UniqueFd& socket) noexcept {
  shutdown(socket.get(), SHUT_RDWR);
  if (refuses_descriptors(socket.get()) || !has_unread(socket.get())) {
    ::close(socket.release());
    return true;
  }
  if (closing_->load(std::memory_order_relaxed) >= kMostThreads) return false;
  closing_->fetch_add(1, std::memory_order_relaxed);
  try {
    Thread thread("close", kStackBytes, [file = socket.get(), closing = closing_] {
      ::close(file);
      closing->fetch_sub(1, std::memory_order_relaxed);
    });
    socket.release();
    thread.join_until(std::chrono::steady_clock::now());  // detaches it
    return true;
  } catch (const std::exception&) {
    closing_->fetch_sub(1, std::memory_order_relaxed);
    return false;
  }
}

}  // namespace slipd
