// What one client still has to be sent. Answers wait as long as they must; of notifications only the newest
// are kept, and the next one that is sent says how many went missing just before it. io thread.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace slipd {

// What subscribers are told of one estimate: a line as far as its `dropped` member, the last of its params.
struct Notification {
  std::string text;
  std::int64_t published_ns = 0;  // of the estimate, CLOCK_MONOTONIC
};

class Backlog {
 public:
  explicit Backlog(std::size_t most_notifications) : most_(most_notifications) {}

  void answer(std::string text);

  // `head`: shared by all clients that get it. `lost`: notifications that went missing before it, already on
  // the way here.
  void notify(std::shared_ptr<const Notification> head, std::uint64_t lost);

  // The next line, with its end; none if all is sent.
  std::optional<std::string> next();
  std::int64_t published_ns() const noexcept { return published_ns_; }  // of what next() gave; 0: an answer

  bool empty() const noexcept { return items_.empty(); }
  std::size_t answer_bytes() const noexcept { return answer_bytes_; }  // of answers that wait
  std::uint64_t dropped() const noexcept { return dropped_; }          // since the client came

 private:
  struct Item {
    std::string answer;
    std::shared_ptr<const Notification> head;  // null: an answer
    std::uint64_t lost = 0;
  };
  void drop_oldest();
  std::size_t most_;
  std::deque<Item> items_;
  std::size_t notifications_ = 0;
  std::size_t answer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
  std::int64_t published_ns_ = 0;
};

}  // namespace slipd
