// Lines that wait to be sent to one client. Responses are never dropped. Of notifications only the newest are
// kept; each says how many were dropped just before it.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// A notification for subscribers, shared by all that get it.
struct Notification {
  // The line up to its member `dropped`, which is the last of its params and differs for each client.
  std::string text;
  // When its estimate was published; ns, CLOCK_MONOTONIC.
  std::int64_t published_ns = 0;
};

// Not thread-safe. Called from one thread: io.
class Backlog {
 public:
  // `max_notifications`: kept at most, at least 1.
  explicit Backlog(std::size_t max_notifications) : max_notifications_(max_notifications) {}

  // Appends a response, without its end of line. `descriptor`: passed along with its first byte; none:
  // nothing.
  void push_response(std::string text, UniqueFd descriptor = {});

  // Appends a notification and drops the oldest one beyond the limit. `lost`: notifications dropped before it
  // elsewhere.
  void push_notification(std::shared_ptr<const Notification> head, std::uint64_t lost);

  // Takes the next line, with its end; none: nothing waits.
  std::optional<std::string> next();
  // Notification::published_ns of the line last taken; 0: it was a response.
  std::int64_t published_ns() const noexcept { return published_ns_; }

  // Takes the descriptor of the line last taken; none: it has none.
  UniqueFd take_descriptor() noexcept { return std::move(descriptor_); }

  // Whether nothing waits.
  bool empty() const noexcept { return items_.empty(); }
  // Notifications dropped since the client connected.
  std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  struct Item {
    std::string response;
    std::shared_ptr<const Notification> head;  // null: a response
    std::uint64_t lost = 0;
    UniqueFd descriptor;
  };
  void drop_oldest();
  std::size_t max_notifications_;
  std::deque<Item> items_;
  std::size_t notifications_ = 0;
  std::uint64_t dropped_ = 0;
  std::int64_t published_ns_ = 0;
  UniqueFd descriptor_;
};

}  // namespace slipd
