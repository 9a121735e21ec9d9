#include "daemon/rpc/clients/socket_watch.hpp"

#include <sys/epoll.h>

#include <array>
#include <cerrno>
#include <new>
#include <span>
#include <system_error>

namespace slipd {
namespace {

// Sockets in one turn, so that events of the sensors do not wait for hundreds of clients.
constexpr std::size_t kMostAtOnce = 64;

int new_set() {
  const int set = epoll_create1(EPOLL_CLOEXEC);
  if (set < 0) throw std::system_error(errno, std::generic_category(), "epoll_create1");
  return set;
}

}  // namespace

SocketWatch::SocketWatch(asio::io_context& io) : ready_(io, new_set()) {
  wait();
}

void SocketWatch::watch(int socket, Watcher& watcher, const Interest& now) {
  const Interest& was = watcher.watched_;
  if (now == was) return;
  epoll_event event{};
  event.events = (now.input ? EPOLLIN : 0U) | (now.room ? EPOLLOUT : 0U);
  event.data.ptr = &watcher;
  const int what = !now.any() ? EPOLL_CTL_DEL : was.any() ? EPOLL_CTL_MOD : EPOLL_CTL_ADD;
  if (epoll_ctl(ready_.native_handle(), what, socket, &event) != 0 && now.any()) throw std::bad_alloc();
  watcher.watched_ = now;
}

void SocketWatch::wait() {
  ready_.async_wait(asio::posix::stream_descriptor::wait_read, [this](const std::error_code& error) {
    if (error) return;
    serve();
    wait();
  });
}

void SocketWatch::serve() {
  std::array<epoll_event, kMostAtOnce> events;
  const int count = epoll_wait(ready_.native_handle(), events.data(), static_cast<int>(events.size()), 0);
  if (count <= 0) return;
  const auto ready = std::span(events).first(static_cast<std::size_t>(count));
  for (const epoll_event& event : ready) {
    const bool hung_up = (event.events & (EPOLLHUP | EPOLLERR)) != 0;
    static_cast<Watcher*>(event.data.ptr)
        ->on_ready({.input = (event.events & EPOLLIN) != 0,
                    .room = (event.events & EPOLLOUT) != 0,
                    .hang_up = hung_up});
  }
  for (const epoll_event& event : ready) static_cast<Watcher*>(event.data.ptr)->answer();
}

}  // namespace slipd
