#include "daemon/rpc/clients/client.hpp"

#include <algorithm>
#include <array>
#include <asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <new>
#include <utility>

#include "core/storage/descriptor_passing.hpp"
#include "daemon/rpc/protocol/rpc.hpp"

namespace slipd {
namespace {

using std::chrono::seconds;

constexpr std::size_t kMaxNotifications = 256;  // queued for one client
// Of answers that a client has requested and not read, beyond which it is not read from. One answer more may
// follow. Less: few requests of large frames in a row. More: many clients that do not read make slipd larger.
constexpr std::size_t kMostOwedBytes = std::size_t{512} * 1024;
constexpr int kMaxLinesAtOnce = 4;
constexpr int kMaxResponsesPending = 16;  // responses expected before reading stops
constexpr auto kLinger = seconds(1);

}  // namespace

Client::Client(UniqueFd socket, Owner& owner)
    : socket_(std::move(socket)),
      may_bear_descriptors_(!refuses_descriptors(socket_.get())),
      linger_timer_(owner.io),
      owner_(owner),
      backlog_(kMaxNotifications),
      owed_(std::make_shared<OwedBytes>(&owner.owed)) {
  prepare_for_bare(socket_.get());
}

// A client that sends no more may still read, but not after it hung up. Without notifications no send would
// fail and show that.
SocketWatch::Interest Client::interest() noexcept {
  return {.input = !input_ended_ && !hold_back(), .room = full_, .hang_up = input_ended_};
}

// Watches the socket for what the client waits for now.
void Client::watch() {
  if (closed_) return;
  with_memory_or_close([&] { owner_.sockets.watch(socket_.get(), *this, interest()); });
}

bool Client::owed_too_much() const noexcept {
  return owed_->bytes() > kMostOwedBytes;
}

// A client that requests faster than it reads responses is not read from (backpressure).
bool Client::over_limit() const noexcept {
  return responses_pending_ >= kMaxResponsesPending || owed_too_much();
}

bool Client::hold_back() noexcept {
  const bool owes_reading = owed_too_much();
  if (owes_reading && !held_back_) ++owner_.held_back;
  held_back_ = owes_reading;
  return over_limit();
}

// Closes the connection if there is no memory, so that the client knows.
template <typename Body>
void Client::with_memory_or_close(Body body) {
  try {
    body();
  } catch (const std::bad_alloc&) {
    close();
  }
}

// Reads one piece and handles some lines of it, so that a client that sends without end does not block the
// others.
void Client::on_ready(const SocketWatch::Interest& ready) {
  if (closed_) return;
  with_memory_or_close([&] {
    if (ready.room || ready.hang_up) full_ = false;
    if (ready.input) {
      if (yielded_) return;
      receive();
      take_lines();
    } else if (ready.hang_up) {
      close();
    }
  });
}

// All that are ready were read before: answers that are sent in a row wake their readers once.
void Client::answer() {
  if (closed_) return;
  with_memory_or_close([&] { go_on(); });
}

void Client::receive() {
  std::array<char, std::size_t{16} * 1024> bytes;
  bool bears_descriptor = false;
  const int socket = socket_.get();
  const auto got = may_bear_descriptors_ ? receive_bare(socket, bytes, bears_descriptor)
                                         : recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (bears_descriptor)
    return turn_away(rpc::kInvalidRequest,
                     "slipd takes no descriptors: `record` answers with one to read the recording from");
  if (got < 0) {
    if (errno != EAGAIN && errno != EINTR) close();
    return;
  }
  if (got == 0) {
    input_ended_ = true;
    *peer_closed_ = true;
  } else if (!discarding_) {
    input_.append(bytes.data(), static_cast<std::size_t>(got));
  }
}

void Client::take_lines() {
  if (parsing_ || yielded_) return;
  parsing_ = true;
  std::size_t start = 0;
  int taken = 0;
  while (!closed_ && !discarding_ && !over_limit() && start < input_.size()) {
    const std::size_t newline = input_.find('\n', start);
    const std::size_t end = std::min(newline, input_.size());
    if (end - start > rpc::kLongestLine) {
      refuse_long_line();
      start = 0;
      break;
    }
    if (newline == std::string::npos && !input_ended_) break;  // the last line needs no end
    if (++taken > kMaxLinesAtOnce) {
      yield();
      break;
    }
    const std::string_view line = std::string_view(input_).substr(start, end - start);
    start = std::min(end + 1, input_.size());
    if (line.find_first_not_of(" \t\r") != std::string::npos) owner_.on_line(shared_from_this(), line);
  }
  input_.erase(0, start);
  parsing_ = false;
}

// Continues after the other clients were served.
void Client::yield() {
  if (std::exchange(yielded_, true)) return;
  asio::post(owner_.io, [self = shared_from_this()] {
    self->yielded_ = false;
    if (!self->closed_) self->with_memory_or_close([&] { self->go_on(); });
  });
}

void Client::refuse_long_line() {
  input_.clear();
  discarding_ = true;
  std::string text =
      rpc::error_text(rpc::kNoId, rpc::kInvalidRequest,
                      "a line is at most " + std::to_string(rpc::kLongestLine) + " bytes long");
  owed_->add(text.size() + 1);
  backlog_.push_response(std::move(text));
  subscriptions.clear();
  linger_timer_.expires_after(kLinger);
  linger_timer_.async_wait([self = shared_from_this()](const std::error_code& error) {
    if (!error) self->close();
  });
}

void Client::respond(std::string text) {
  if (responses_pending_ > 0) --responses_pending_;
  if (closed_) return;
  with_memory_or_close([&] {
    if (!text.empty()) {
      owed_->add(text.size() + 1);  // with its end of line
      backlog_.push_response(std::move(text), std::move(passing_));
    }
    passing_ = {};           // a notification has no response
    if (!parsing_) go_on();  // otherwise it is sent after all that are ready were read
  });
}

void Client::notify(std::shared_ptr<const Notification> head, std::uint64_t lost) {
  if (closed_) return;
  backlog_.push_notification(std::move(head), lost);
  flush();
}

void Client::announce(std::string text) {
  if (closed_) return;
  const std::size_t bytes = text.size() + 1;  // with its end of line
  backlog_.push_response(std::move(text));
  owed_->add(bytes);
  flush();
}

void Client::turn_away(int code, const std::string& why) {
  if (closed_) return;
  const bool within_a_line = sent_ > 0 && sent_ < output_.size();
  if (!within_a_line) {
    const std::string text = rpc::error_text(rpc::kNoId, code, why) + "\n";
    [[maybe_unused]] const auto sent =
        send(socket_.get(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  }
  close();
}

void Client::flush() {
  while (!closed_ && !full_) {
    if (sent_ == output_.size()) {
      auto next = backlog_.next();
      if (!next) break;
      output_ = std::move(*next);
      output_fd_ = backlog_.take_descriptor();
      sent_ = 0;
    }
    const auto sent = send_some();
    if (sent >= 0) {
      sent_ += static_cast<std::size_t>(sent);
      if (sent_ == output_.size()) sent_whole();
    } else if (errno == EAGAIN) {
      full_ = true;
      watch();
    } else if (errno != EINTR) {
      close();
    }
  }
  if (!closed_ && discarding_ && backlog_.empty() && sent_ == output_.size()) {
    shutdown(socket_.get(), SHUT_WR);
  }
}

// Sends what the socket takes of output_. Its descriptor goes with the first byte.
ssize_t Client::send_some() noexcept {
  const auto sent = send_passing(socket_.get(), std::string_view(output_).substr(sent_), output_fd_.get(),
                                 MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent > 0) output_fd_ = {};
  return sent;
}

// After a whole line was handed to the kernel. Its memory is released, because the next one may be long in
// coming.
void Client::sent_whole() {
  if (backlog_.published_ns() != 0) {
    owner_.on_notification_sent(backlog_.published_ns());
  } else {
    owed_->settle(output_.size());
  }
  output_ = {};
  sent_ = 0;
}

// Takes lines that wait for a place, and sends what the socket takes.
void Client::go_on() {
  flush();
  take_lines();
  flush();
  close_if_done();
  watch();
}

void Client::close_if_done() {
  const bool all_sent = backlog_.empty() && sent_ == output_.size();
  if (input_ended_ && !yielded_ && input_.empty() && all_sent && responses_pending_ == 0 &&
      subscriptions.empty())
    close();
}

void Client::close() {
  if (closed_) return;
  owner_.sockets.watch(socket_.get(), *this, {});
  closed_ = true;
  attachment.reset();
  *peer_closed_ = true;
  linger_timer_.cancel();
  leaving_ = std::move(socket_);
  let_go();
  // Posted, because the owner may be iterating over its clients.
  try {
    asio::post(owner_.io, [self = shared_from_this()] { self->owner_.on_closed(); });
  } catch (const std::bad_alloc&) {  // Server::update_statistics removes closed clients too
  }
}

ucred Client::peer() const noexcept {
  ucred who{0, static_cast<uid_t>(-1), static_cast<gid_t>(-1)};
  socklen_t length = sizeof who;
  getsockopt(socket_.get(), SOL_SOCKET, SO_PEERCRED, &who, &length);
  return who;
}

}  // namespace slipd
