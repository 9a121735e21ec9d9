// What one client still has to be sent. Answers wait as long as they must; of notifications only the newest
// are kept, and the next one that is sent says how many went missing just before it. io thread.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace slipd {

class Backlog {
 public:
  explicit Backlog(std::size_t most_notifications) : most_(most_notifications) {}

  void answer(std::string text);

  // `head`: the notification as far as its `dropped` member, which is the last of its params; shared by all
  // clients that get it. `lost`: notifications that went missing before it, already on the way here.
  void notify(std::shared_ptr<const std::string> head, std::uint64_t lost);

  // The next line, with its end; none if all is sent.
  std::optional<std::string> next();

  bool empty() const noexcept { return items_.empty(); }
  std::size_t answer_bytes() const noexcept { return answer_bytes_; }  // of answers that wait
  std::uint64_t dropped() const noexcept { return dropped_; }          // since the client came

 private:
  struct Item {
    std::string answer;
    std::shared_ptr<const std::string> head;  // null: an answer
    std::uint64_t lost = 0;
  };
  void drop_oldest();
  std::size_t most_;
  std::deque<Item> items_;
  std::size_t notifications_ = 0;
  std::size_t answer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace slipd
