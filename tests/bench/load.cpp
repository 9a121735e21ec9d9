#include "tests/bench/load.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "tests/bench/floors.hpp"

namespace slipd::bench {
namespace {

struct Connection {
  int fd = -1;
  bool asks = true;
  int newlines = 0;
  std::int64_t asked_ns = 0;
  std::size_t bytes = 0;
};

void write_all(int fd, const std::string& text) {
  if (send(fd, text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size())) fail("send");
}

}  // namespace

int connect_to(const std::filesystem::path& socket) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, socket.c_str(), sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) fail("socket");
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  fail("connect");
}

Asked ask_for(const Asking& asking, std::chrono::milliseconds long_enough) {
  const int events = epoll_create1(EPOLL_CLOEXEC);
  std::vector<Connection> all(static_cast<std::size_t>(asking.clients + asking.subscribers));
  for (std::size_t i = 0; i < all.size(); ++i) {
    Connection& each = all[i];
    each.fd = connect_to(asking.socket);
    each.asks = static_cast<int>(i) < asking.clients;
    epoll_event wanted{EPOLLIN, {.u64 = i}};
    epoll_ctl(events, EPOLL_CTL_ADD, each.fd, &wanted);
    if (!each.asks) write_all(each.fd, asking.subscription);
  }
  Asked result;
  std::vector<std::int64_t> waits;
  waits.reserve(4'000'000);
  const auto ask = [&](Connection& each) {
    each.newlines = 0;
    each.bytes = 0;
    each.asked_ns = now_ns();
    write_all(each.fd, asking.request);
  };
  const std::int64_t begun_ns = now_ns(), warm_ns = begun_ns + 100'000'000,
                     until_ns = warm_ns + std::chrono::nanoseconds(long_enough).count();
  for (Connection& each : all)
    if (each.asks) ask(each);
  std::vector<char> piece(std::size_t{64} * 1024);
  std::array<epoll_event, 256> ready;
  std::size_t answered = 0;
  for (std::int64_t now = begun_ns; now < until_ns;) {
    const int count = epoll_wait(events, ready.data(), ready.size(), 1000);
    for (int i = 0; i < count; ++i) {
      Connection& each = all[ready[static_cast<std::size_t>(i)].data.u64];
      const ssize_t got = recv(each.fd, piece.data(), piece.size(), MSG_DONTWAIT);
      if (got <= 0) throw std::system_error(ECONNRESET, std::generic_category(), "the server hung up");
      const auto newlines = static_cast<int>(std::count(piece.data(), piece.data() + got, '\n'));
      now = now_ns();
      if (!each.asks) {
        result.heard += static_cast<std::uint64_t>(newlines);
        continue;
      }
      each.newlines += newlines;
      each.bytes += static_cast<std::size_t>(got);
      if (each.newlines < asking.newlines) continue;
      result.answer_bytes = each.bytes;
      if (now >= warm_ns) {
        ++answered;
        if (waits.size() < waits.capacity()) waits.push_back(now - each.asked_ns);
      }
      ask(each);
    }
    now = now_ns();
  }
  for (const Connection& each : all) close(each.fd);
  close(events);
  result.per_second = static_cast<double>(answered) / std::chrono::duration<double>(long_enough).count();
  result.waits = quantiles_of(std::move(waits));
  return result;
}

}  // namespace slipd::bench
