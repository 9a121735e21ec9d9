#include "daemon/rpc/client.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <new>
#include <utility>

#include "daemon/rpc/descriptors.hpp"
#include "daemon/rpc/rpc.hpp"

namespace slipd {
namespace {

using std::chrono::seconds;

constexpr std::size_t kMostNotifications = 256;                     // that wait for one client
constexpr std::size_t kMostAnswerBytes = std::size_t{1024} * 1024;  // that wait, before no more is read
constexpr int kMostLinesAtOnce = 4;
constexpr int kMostAwaited = 16;  // answers under way, before no more is read
constexpr std::size_t kMostPassedFds = 4;
constexpr std::uint64_t kFew = 4;  // clients that have had their turn since one's last
constexpr auto kPatience = seconds(1);

}  // namespace

Client::Client(asio::io_context& io, UniqueFd socket, Owner& owner)
    : socket_(io, socket.release()), patience_(io), owner_(owner), backlog_(kMostNotifications) {}

void Client::read_when_ready() {
  if (closed_ || reading_ || input_ended_ || resting_ || crowded()) return;
  reading_ = true;
  socket_.async_wait(asio::posix::stream_descriptor::wait_read,
                     [self = shared_from_this()](const std::error_code& error) {
                       self->reading_ = false;
                       if (error || self->closed_) return;
                       self->with_memory_or_close([&] { self->on_readable(); });
                     });
}

// A client that asks faster than it takes its answers has to wait.
bool Client::crowded() const noexcept {
  return awaited_ >= kMostAwaited || backlog_.answer_bytes() > kMostAnswerBytes;
}

// Where there is no memory to serve it, the connection ends, and the client knows.
template <typename Body>
void Client::with_memory_or_close(Body body) {
  try {
    body();
  } catch (const std::bad_alloc&) {
    close();
  }
}

// One piece, and some lines of it, at a time, so that a client that sends without end does not keep the loop
// from the others. Where many ask, all that has come is read before anything is answered: answers that go out
// one after the other wake their reader once.
void Client::on_readable() {
  ++owner_.turns;
  const bool many_ask = owner_.turns - std::exchange(turn_, owner_.turns) > kFew;
  receive();
  take_lines();
  if (many_ask && !closed_) rest();
  if (resting_) return;
  flush();
  let_go_if_done();
  read_when_ready();
}

void Client::receive() {
  std::array<char, std::size_t{16} * 1024> bytes;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int) * kMostPassedFds)> control;
  iovec piece{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const auto got = recvmsg(socket_.native_handle(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (got < 0) {
    if (errno != EAGAIN && errno != EINTR) close();
    return;
  }
  for (cmsghdr* item = CMSG_FIRSTHDR(&message); item != nullptr; item = CMSG_NXTHDR(&message, item)) {
    if (item->cmsg_level != SOL_SOCKET || item->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (item->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(item) + i * sizeof(int), sizeof fd);
      passed_.push_back(out_of_the_way(UniqueFd(fd)));
      if (passed_.size() > kMostPassedFds) passed_.pop_front();
    }
  }
  if (got == 0) {
    input_ended_ = true;
    *left_ = true;
  } else if (!discarding_) {
    input_.append(bytes.data(), static_cast<std::size_t>(got));
  }
}

void Client::take_lines() {
  if (taking_ || resting_) return;
  taking_ = true;
  std::size_t start = 0;
  int taken = 0;
  while (!closed_ && !discarding_ && !crowded() && start < input_.size()) {
    const std::size_t newline = input_.find('\n', start);
    const std::size_t end = std::min(newline, input_.size());
    if (end - start > rpc::kLongestLine) {
      refuse_long_line();
      start = 0;
      break;
    }
    if (newline == std::string::npos && !input_ended_) break;  // the last line may do without its end
    if (++taken > kMostLinesAtOnce) {
      rest();
      break;
    }
    const std::string_view line = std::string_view(input_).substr(start, end - start);
    start = std::min(end + 1, input_.size());
    if (line.find_first_not_of(" \t\r") != std::string::npos) owner_.line(shared_from_this(), line);
  }
  input_.erase(0, start);
  taking_ = false;
}

// Goes on when the others have had their turn.
void Client::rest() {
  if (std::exchange(resting_, true)) return;
  asio::post(socket_.get_executor(), [self = shared_from_this()] {
    self->resting_ = false;
    if (!self->closed_) self->with_memory_or_close([&] { self->on_writable(); });
  });
}

void Client::refuse_long_line() {
  input_.clear();
  discarding_ = true;
  backlog_.answer(rpc::error_text(rpc::kNoId, rpc::kInvalidRequest,
                                  "a line is at most " + std::to_string(rpc::kLongestLine) + " bytes long"));
  subscriptions.clear();
  patience_.expires_after(kPatience);
  patience_.async_wait([self = shared_from_this()](const std::error_code& error) {
    if (!error) self->close();
  });
}

void Client::answer(std::string text) {
  if (awaited_ > 0) --awaited_;
  if (closed_) return;
  with_memory_or_close([&] {
    if (!text.empty()) backlog_.answer(std::move(text));
    if (!taking_) on_writable();  // else it is sent when all lines are taken
  });
}

void Client::notify(std::shared_ptr<const Notification> head, std::uint64_t lost) {
  if (closed_) return;
  backlog_.notify(std::move(head), lost);
  flush();
}

void Client::flush() {
  while (!closed_ && !writing_) {
    if (sent_ == output_.size()) {
      auto next = backlog_.next();
      if (!next) break;
      output_ = std::move(*next);
      sent_ = 0;
    }
    const auto sent = send(socket_.native_handle(), output_.data() + sent_, output_.size() - sent_,
                           MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0) {
      sent_ += static_cast<std::size_t>(sent);
      if (sent_ == output_.size() && backlog_.published_ns() != 0) owner_.told(backlog_.published_ns());
    } else if (errno == EAGAIN) {
      writing_ = true;
      socket_.async_wait(asio::posix::stream_descriptor::wait_write,
                         [self = shared_from_this()](const std::error_code& error) {
                           self->writing_ = false;
                           if (error || self->closed_) return;
                           self->with_memory_or_close([&] { self->on_writable(); });
                         });
    } else if (errno != EINTR) {
      close();
    }
  }
  if (!closed_ && discarding_ && backlog_.empty() && sent_ == output_.size()) {
    shutdown(socket_.native_handle(), SHUT_WR);
  }
}

void Client::on_writable() {
  flush();
  take_lines();
  flush();
  let_go_if_done();
  read_when_ready();
}

void Client::let_go_if_done() {
  const bool all_said = backlog_.empty() && sent_ == output_.size();
  if (!input_ended_ || resting_) return;
  if (input_.empty() && all_said && awaited_ == 0 && subscriptions.empty()) return close();
  notice_hang_up();
}

// One that sends no more may still read, but not once it is gone for good: where there is nothing to tell a
// subscriber, no failing send would ever say so.
void Client::notice_hang_up() {
  if (closed_ || noticing_) return;
  pollfd now{socket_.native_handle(), 0, 0};
  if (poll(&now, 1, 0) == 1 && (now.revents & (POLLHUP | POLLERR)) != 0) return close();
  noticing_ = true;
  socket_.async_wait(asio::posix::stream_descriptor::wait_error,
                     [self = shared_from_this()](const std::error_code& error) {
                       self->noticing_ = false;
                       if (!error) self->notice_hang_up();
                     });
}

void Client::close() {
  if (closed_) return;
  closed_ = true;
  *left_ = true;
  patience_.cancel();
  std::error_code ignored;
  socket_.close(ignored);
  // Later: the owner may just be going through its clients.
  try {
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->owner_.gone(self); });
  } catch (const std::bad_alloc&) {  // it looks for closed ones now and then
  }
}

ucred Client::peer() const noexcept {
  ucred who{0, static_cast<uid_t>(-1), static_cast<gid_t>(-1)};
  socklen_t length = sizeof who;
  getsockopt(const_cast<asio::posix::stream_descriptor&>(socket_).native_handle(), SOL_SOCKET, SO_PEERCRED,
             &who, &length);
  return who;
}

UniqueFd Client::take_fd() {
  if (passed_.empty()) return {};
  UniqueFd fd = std::move(passed_.front());
  passed_.pop_front();
  return fd;
}

}  // namespace slipd
