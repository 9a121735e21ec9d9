// Files of every kind that a client may pass to slipd, and how to pass them. The last to close a lingering
// connection waits: for an hour here, which no test does.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <array>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/storage/descriptor_passing.hpp"
#include "tests/support/rpc_client.hpp"

namespace slipd::testing {

// Closes a file where nothing waits for it: this process may be the last to hold it.
inline void close_elsewhere(UniqueFd file) {
  std::thread([held = file.release()] { close(held); }).detach();
}

// Two ends of a stream socket.
inline std::array<UniqueFd, 2> socket_pair() {
  std::array<int, 2> ends{-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw std::runtime_error("socketpair");
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

// Peers of TCP connections that are never read from.
class SilentPeer {
 public:
  SilentPeer() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    setsockopt(listener_.get(), SOL_SOCKET, SO_RCVBUF, &kTaken, sizeof kTaken);
    socklen_t length = sizeof address_;
    auto* const any = reinterpret_cast<sockaddr*>(&address_);
    if (bind(listener_.get(), any, length) != 0 || listen(listener_.get(), 4096) != 0 ||
        getsockname(listener_.get(), any, &length) != 0)
      throw std::runtime_error("no TCP on this machine");
  }

  // A connection with a full buffer. Its last close waits an hour, or until this object is destroyed.
  UniqueFd lingering() const {
    UniqueFd made(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    setsockopt(made.get(), SOL_SOCKET, SO_SNDBUF, &kSent, sizeof kSent);
    if (connect(made.get(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_) != 0)
      throw std::runtime_error("connect by TCP");
    const linger hour{1, 3600};
    setsockopt(made.get(), SOL_SOCKET, SO_LINGER, &hour, sizeof hour);
    const std::string much(65536, 'x');
    while (send(made.get(), much.data(), much.size(), MSG_DONTWAIT | MSG_NOSIGNAL) > 0) {
    }
    return made;
  }

 private:
  // Bytes that one end has room for: far more than its peer, so that much is always left to send.
  static constexpr int kSent = 65536, kTaken = 2048;
  UniqueFd listener_;
  sockaddr_in address_{};
};

// Kinds of files. `lingering` is last, so that others can be drawn without it.
enum class PassedKind {
  pipe_to_read,
  pipe_to_write,
  memory,
  path,
  epoll,
  itself,
  nested,
  folder,
  board,
  lingering
};
inline constexpr int kPassedKinds = 10;

// A new file of this kind. `board`: slipd's own memory, as `attach` passes it; `socket`: slipd's.
inline UniqueFd passed_file(PassedKind kind, const SilentPeer& peer, const std::filesystem::path& socket) {
  std::array<int, 2> pipe{-1, -1};
  switch (kind) {
    case PassedKind::pipe_to_read:
    case PassedKind::pipe_to_write: {
      if (pipe2(pipe.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
      UniqueFd reading(pipe[0]), writing(pipe[1]);
      return kind == PassedKind::pipe_to_read ? std::move(reading) : std::move(writing);
    }
    case PassedKind::memory:
      return UniqueFd(memfd_create("passed", MFD_CLOEXEC));
    case PassedKind::path:
      return UniqueFd(open("/proc/self/exe", O_PATH | O_CLOEXEC));
    case PassedKind::epoll: {
      UniqueFd made(epoll_create1(EPOLL_CLOEXEC));
      const auto ends = socket_pair();
      epoll_event event{};
      epoll_ctl(made.get(), EPOLL_CTL_ADD, ends[0].get(), &event);
      return made;
    }
    case PassedKind::itself: {  // a cycle, which only the kernel's collector of such frees
      auto ends = socket_pair();
      send_passing(ends[0].get(), "x", ends[1].get(), MSG_NOSIGNAL);
      send_passing(ends[1].get(), "x", ends[0].get(), MSG_NOSIGNAL);
      return std::move(ends[1]);
    }
    case PassedKind::nested: {
      auto within = socket_pair();
      auto around = socket_pair();
      send_passing(within[0].get(), "x", peer.lingering().get(), MSG_NOSIGNAL);
      send_passing(around[0].get(), "x", within[1].get(), MSG_NOSIGNAL);
      return std::move(around[1]);
    }
    case PassedKind::folder:
      return UniqueFd(open("/", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    case PassedKind::board: {
      RpcClient client(socket);
      client.call("attach");
      return client.take_descriptor();
    }
    case PassedKind::lingering:
      return peer.lingering();
  }
  return {};
}

}  // namespace slipd::testing
