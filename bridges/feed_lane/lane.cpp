#include "bridges/feed_lane/lane.hpp"

#include <utility>

#include "wire/number.hpp"

namespace slipd::feed {
namespace {

// A sequence that does not rise is a repetition, or one that was overtaken; after so long without a rise the
// sender has begun anew. Shorter: a network that delays a message for longer hands it on. Longer: the next
// frames of a sender that was restarted are lost.
constexpr std::int64_t kAnewNs = 1'000'000'000;
// Steps of a sequence above this are no count of lost messages.
constexpr std::int64_t kLongestJump = std::int64_t{1} << 31;

}  // namespace

Lane::Lane(std::string sensor, const slipd_frames& frames, std::unique_ptr<MessageReader> reader,
           const std::string& socket)
    : sensor_(std::move(sensor)), reader_(std::move(reader)), writer_(sensor_, frames, socket) {}

// By how many messages the sender is ahead of its last one: 1 if none is missing; 0: this one is not newer.
std::uint64_t Lane::step_of(const Reading& reading, std::int64_t now_ns) {
  std::uint64_t step = 1;
  if (reading.sequence) {
    const std::int64_t moved = last_ ? wire::steps(*last_, *reading.sequence, reading.sequence_bytes) : 1;
    if (moved <= 0 && now_ns - taken_ns_ < kAnewNs) return 0;
    if (moved <= 0) clock_.reset();
    if (moved > 0 && reading.counted && moved < kLongestJump) step = static_cast<std::uint64_t>(moved);
    last_ = reading.sequence;
  }
  taken_ns_ = now_ns;
  return step;
}

void Lane::count(Outcome outcome, std::uint64_t step) {
  const std::lock_guard lock(mutex_);
  ++account_.messages;
  if (outcome == Outcome::other) ++account_.other;
  if (outcome == Outcome::corrupt) ++account_.corrupt;
  if (outcome != Outcome::frame) {
    account_.why = reader_->why();
  } else if (step == 0) {
    ++account_.repeated;
    account_.why = "its sequence does not rise";
  } else {
    account_.lost += step - 1;
  }
}

void Lane::take(const Message& message, std::int64_t now_ns) {
  constexpr double kNsPerSecond = 1e9;
  Reading reading;
  const Outcome outcome = reader_->read(message, reading);
  const std::uint64_t step = outcome == Outcome::frame ? step_of(reading, now_ns) : 0;
  count(outcome, step);
  if (step == 0) return;
  sequence_ += step;
  const auto ns = [](double s) { return static_cast<std::int64_t>(s * kNsPerSecond); };
  put(reading, reading.sent_s ? clock_.when(ns(*reading.sent_s), now_ns, ns(reading.sent_range_s)) : now_ns);
  if (reading.sent_s) flush();
}

void Lane::put(Reading& reading, std::int64_t time_ns) {
  const bool overtaken = pending_.has_value();
  pending_ = Frame{std::move(reading.values), time_ns, sequence_};
  if (!overtaken) return;
  const std::lock_guard lock(mutex_);
  ++account_.overtaken;
  account_.why = "another one waited behind it, and it has no time";
}

void Lane::flush() {
  if (!pending_) return;
  writer_.put(std::move(*pending_));
  pending_.reset();
}

void Lane::refuse(const char* why) {
  const std::lock_guard lock(mutex_);
  ++account_.messages;
  ++account_.corrupt;
  account_.why = why;
}

void Lane::refuse_second() {
  const std::lock_guard lock(mutex_);
  ++account_.messages;
  ++account_.second;
  account_.why = "another sender was there first, and sends";
}

void Lane::lose(std::uint64_t messages) {
  sequence_ += messages;
  const std::lock_guard lock(mutex_);
  account_.lost += messages;
}

void Lane::source_is(std::string trouble) {
  clock_.reset();
  last_.reset();
  pending_.reset();
  const std::lock_guard lock(mutex_);
  if (account_.source.empty() && !trouble.empty()) ++account_.losses;
  account_.source = std::move(trouble);
}

Account Lane::account() const {
  Account account;
  {
    const std::lock_guard lock(mutex_);
    account = account_;
  }
  account.sent = writer_.sent();
  account.unsent = writer_.unsent();
  account.trouble = writer_.trouble();
  return account;
}

}  // namespace slipd::feed
