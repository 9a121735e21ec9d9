// One connection to the socket: lines in, lines and descriptors out. Reads and writes what the socket takes
// without blocking. slipd takes no descriptor from a client: the kernel refuses to send one; where it cannot,
// who passes one is turned away.
#pragma once

#include <sys/socket.h>

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <string_view>

#include "core/storage/unique_fd.hpp"
#include "daemon/board/shared_board.hpp"
#include "daemon/rpc/clients/backlog.hpp"
#include "daemon/rpc/clients/socket_closer.hpp"
#include "daemon/rpc/clients/socket_watch.hpp"
#include "daemon/rpc/clients/subscription.hpp"
#include "daemon/rpc/protocol/owed_bytes.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class Client final : public std::enable_shared_from_this<Client>, private SocketWatch::Watcher {
 public:
  // What all clients of a server share: the callbacks, and counters.
  struct Owner {
    explicit Owner(asio::io_context& of) : io(of), sockets(of) {}
    // Where the clients' timers run.
    asio::io_context& io;
    // Tells when their sockets are ready.
    SocketWatch sockets;
    // Called with each whole line, without its end. Not null.
    std::function<void(const std::shared_ptr<Client>&, std::string_view line)> on_line;
    // Called once after the connection was closed. Not null.
    std::function<void()> on_closed;
    // Called after a whole notification was handed to the kernel, with Notification::published_ns. Not null.
    std::function<void(std::int64_t published_ns)> on_notification_sent;
    // Bytes of answers that the clients have requested and not read yet.
    OwedBytes owed;
    // How often a client was not read from any more because it did not read its answers.
    std::uint64_t held_back = 0;
    // Closes their sockets.
    SocketCloser closer;
  };

  // `owner` outlives it; its callbacks may be replaced.
  Client(UniqueFd socket, Owner& owner);
  // Leaves a socket that could not be let go to the end of the process, which waits for nothing.
  ~Client() override { leaving_.release(); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  // Starts reading. Once.
  void start() { watch(); }
  // Sends a response to one line; empty: there is none, because the line had only notifications.
  void respond(std::string text);
  // Sends a notification; `lost` as in Backlog.
  void notify(std::shared_ptr<const Notification> head, std::uint64_t lost);
  // Sends a notification that is never dropped and counts as an answer.
  void announce(std::string text);
  // Sends an error without a request, if there is room for it, and closes the connection.
  void turn_away(int code, const std::string& why);
  // Closes the connection at once. Lines that wait are lost.
  void close();
  // Lets the socket of a closed connection go. False: that is not possible now; call it again later.
  bool let_go() noexcept { return closed_ && (!leaving_ || owner_.closer.close(leaving_)); }
  // Whether the connection is closed.
  bool closed() const noexcept { return closed_; }

  // Promises an answer of about so many bytes, until the returned part is destroyed. A client that is owed
  // too much is not read from.
  OwedPart promise(std::size_t bytes) { return {owed_, bytes}; }
  // Whether it is owed so much that it gets nothing more before it has read.
  bool owed_too_much() const noexcept;

  // Announces that respond will be called later. Until then a client that closed its sending side stays
  // connected.
  void expect_response() { ++responses_pending_; }

  // Process, user and group of the peer (SO_PEERCRED); user and group -1: unknown.
  ucred peer() const noexcept;
  // Passes a descriptor along with the next response, which the caller sends at once.
  void pass_with_response(UniqueFd descriptor) noexcept { passing_ = std::move(descriptor); }
  // What the client holds of the board's shared memory; null: it has not attached to the present one.
  SharedBoard::Attachment attachment;
  // SharedBoard::generation of `attachment`.
  std::uint64_t attached_generation = 0;
  // A flag that becomes true when the client sends no more or is closed. Written by io, read from any thread.
  std::shared_ptr<std::atomic<bool>> peer_closed() const { return peer_closed_; }
  // Notifications dropped since the client connected.
  std::uint64_t dropped() const noexcept { return backlog_.dropped(); }

  // The client's subscriptions.
  std::list<Subscription> subscriptions;
  // Subscriptions made since it connected; numbers them.
  int subscriptions_made = 0;

 private:
  void on_ready(const SocketWatch::Interest& ready) override;
  void answer() override;
  void go_on();
  void watch();
  SocketWatch::Interest interest() noexcept;
  template <typename Body>
  void with_memory_or_close(Body body);
  void receive();
  void take_lines();
  void yield();
  bool over_limit() const noexcept;
  bool hold_back() noexcept;
  void refuse_long_line();
  void flush();
  ssize_t send_some() noexcept;
  void sent_whole();
  void close_if_done();

  UniqueFd socket_;                  // until it is closed
  const bool may_bear_descriptors_;  // the kernel does not refuse them
  asio::steady_timer linger_timer_;  // closes a client that goes on sending after it was refused
  Owner& owner_;
  Backlog backlog_;
  std::string input_;
  std::string output_;    // the line that is being sent
  std::size_t sent_ = 0;  // of output_
  UniqueFd passing_;      // goes with the next response
  UniqueFd output_fd_;    // goes with the first byte of output_
  UniqueFd leaving_;      // the socket of a closed connection, until it is let go
  // Written by io, read by the writer of a recording that this client requested. No other memory is read
  // because of it.
  std::shared_ptr<std::atomic<bool>> peer_closed_ = std::make_shared<std::atomic<bool>>(false);
  std::shared_ptr<OwedBytes> owed_;  // shared with promises, which may outlive it
  int responses_pending_ = 0;
  bool full_ = false;     // the socket takes no more output
  bool parsing_ = false;  // take_lines is running; a response within it must not start it again
  bool yielded_ = false;  // it has more lines, but other clients are served first
  bool input_ended_ = false;
  bool held_back_ = false;   // it is not read from, because it owes reading
  bool discarding_ = false;  // its line was too long: input is discarded, then it is closed
  bool closed_ = false;
};

}  // namespace slipd
