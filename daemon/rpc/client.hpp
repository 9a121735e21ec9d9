// One connection: lines in, lines out, descriptors passed along. Reads and writes what the socket takes at
// once and never waits for it. io thread.
#pragma once

#include <sys/socket.h>

#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <string_view>

#include "core/storage/unique_fd.hpp"
#include "daemon/rpc/backlog.hpp"
#include "daemon/rpc/subscription.hpp"

namespace slipd {

class Client : public std::enable_shared_from_this<Client> {
 public:
  struct Owner {
    std::function<void(const std::shared_ptr<Client>&, std::string_view line)>
        line;                                                  // a whole line, without its end
    std::function<void(const std::shared_ptr<Client>&)> gone;  // said once
    std::function<void(std::int64_t published_ns)> told;       // a whole notification has gone to the kernel
    std::uint64_t turns = 0;                                   // of all clients, when input was there
  };

  Client(asio::io_context& io, UniqueFd socket, Owner& owner);

  void start() { read_when_ready(); }
  void answer(std::string text);  // one whole answer; empty: there is nothing to say
  void notify(std::shared_ptr<const Notification> head, std::uint64_t lost);
  void close();
  bool closed() const noexcept { return closed_; }

  // An answer will come later: until then a client that has stopped sending is not let go.
  void await_answer() { ++awaited_; }

  ucred peer() const noexcept;  // who is at the other end: process, user, group
  UniqueFd take_fd();           // the descriptor that was passed longest ago; empty: none
  // True once it sends no more or is gone. For threads that work for it.
  std::shared_ptr<std::atomic<bool>> left() const { return left_; }
  std::uint64_t dropped() const noexcept { return backlog_.dropped(); }

  std::list<Subscription> subscriptions;
  int subscriptions_made = 0;  // since it came; numbers them

 private:
  void read_when_ready();
  void on_readable();
  void on_writable();
  template <typename Body>
  void with_memory_or_close(Body body);
  void receive();
  void take_lines();
  void rest();
  bool crowded() const noexcept;
  void refuse_long_line();
  void flush();
  void let_go_if_done();
  void notice_hang_up();

  asio::posix::stream_descriptor socket_;
  asio::steady_timer patience_;  // for a client that is to be closed but goes on sending
  Owner& owner_;
  Backlog backlog_;
  std::string input_;
  std::string output_;    // the line that is being sent
  std::size_t sent_ = 0;  // of output_
  std::deque<UniqueFd> passed_;
  // io sets it, the writer of a recording that this client asked for looks at it; nothing else goes with it.
  std::shared_ptr<std::atomic<bool>> left_ = std::make_shared<std::atomic<bool>>(false);
  int awaited_ = 0;
  std::uint64_t turn_ = 0;  // its last one
  bool reading_ = false;    // a wait for input is pending
  bool writing_ = false;    // a wait for room is pending
  bool noticing_ = false;   // a wait for the other end to hang up is pending
  bool taking_ = false;     // lines out of input_: not to be begun again by an answer to one of them
  bool resting_ = false;    // there are more lines, but it is the others' turn
  bool input_ended_ = false;
  bool discarding_ = false;  // said too much in one line: read on to be polite, then close
  bool closed_ = false;
};

}  // namespace slipd
