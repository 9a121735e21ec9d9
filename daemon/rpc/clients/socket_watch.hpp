// Which clients' sockets have input or room, asked of the kernel for all of them at once: an epoll set of
// their own costs one wait for all that are ready, where a wait of Asio's costs a system call for each
// request.
#pragma once

#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <cstdint>

namespace slipd {

// Not thread-safe. Called from one thread: io.
class SocketWatch {
 public:
  // What a socket is watched for, or ready for.
  struct Interest {
    // It has input, or the other end sends no more.
    bool input = false;
    // It takes output.
    bool room = false;
    // The other end closed the connection. A socket that is watched for anything tells this too.
    bool hang_up = false;
    bool operator==(const Interest&) const = default;
    // Whether the socket is watched at all.
    bool any() const noexcept { return input || room || hang_up; }
  };
  // Whose socket it is. Not destroyed while one of its functions is running, nor while its socket is watched.
  class Watcher {
   public:
    // The socket is ready for this. Called for all that are ready, before any answers.
    virtual void on_ready(const Interest& ready) = 0;
    // Called after on_ready was called for all.
    virtual void answer() = 0;

   protected:
    virtual ~Watcher() = default;

   private:
    friend SocketWatch;
    Interest watched_;  // as the kernel has it
  };

  // Throws std::system_error if the system has no descriptor.
  explicit SocketWatch(asio::io_context& io);
  // Watches `socket`, the watcher's only one, from now on for this, and for nothing it was watched for
  // before. Throws std::bad_alloc if the system has no memory for it.
  void watch(int socket, Watcher& watcher, const Interest& now);

 private:
  void wait();
  void serve();
  asio::posix::stream_descriptor ready_;  // the epoll set, which is readable while a socket of it is ready
};

}  // namespace slipd
