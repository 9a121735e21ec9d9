// One sensor: messages of its source → frames for slipd, and the account of both. Messages come in the
// source's thread; account() may be called in another.
//
// A message of a sender with a clock gets the time at which it was sent, and slipd judges its age. Without a
// clock nobody knows how long a message waited: of those that had come when the source was read, only the
// last becomes a frame.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <slipd.hpp>
#include <string>

#include "bridges/feed_lane/message_reader.hpp"
#include "bridges/feed_lane/sender_clock.hpp"
#include "bridges/feed_lane/writer.hpp"

namespace slipd::feed {

// Of messages, since the start.
struct Account {
  std::uint64_t messages = 0;   // all that came
  std::uint64_t other = 0;      // of another kind or sensor
  std::uint64_t corrupt = 0;    // damaged, wrong size, not finite
  std::uint64_t repeated = 0;   // whose sequence does not rise
  std::uint64_t lost = 0;       // which the sequence or the source counts and which did not come whole
  std::uint64_t second = 0;     // of a second sender, while the first one sends
  std::uint64_t overtaken = 0;  // without a time, behind which another one waited
  std::uint64_t sent = 0;       // frames that slipd took
  std::uint64_t unsent = 0;     // frames that slipd did not take
  std::uint64_t losses = 0;     // of the source
  std::string why;              // what the last message that became no frame lacked
  std::string trouble;          // why slipd took none the last time; empty: it took it
  std::string source;           // what is wrong with the source; empty: nothing
};

class Lane {
 public:
  // `frames`: of the hello to slipd. `reader`: of this sensor's messages. `socket`: slipd's. Throws
  // client::Error.
  Lane(std::string sensor, const slipd_frames& frames, std::unique_ptr<MessageReader> reader,
       const std::string& socket);

  const std::string& sensor() const noexcept { return sensor_; }
  // A whole message that came at `now_ns`, CLOCK_MONOTONIC.
  void take(const Message& message, std::int64_t now_ns);
  // A message, or part of one, that cannot be used.
  void refuse(const char* why);
  // A message of a second sender, while the first one sends.
  void refuse_second();
  // So many messages were sent and did not come.
  void lose(std::uint64_t messages);
  // Nothing waits behind the last message.
  void flush();
  // The source cannot be had, or can again (empty). The next messages begin anew.
  void source_is(std::string trouble);
  Account account() const;

 private:
  std::uint64_t step_of(const Reading& reading, std::int64_t now_ns);
  void count(Outcome outcome, std::uint64_t step);
  void put(Reading& reading, std::int64_t time_ns);

  const std::string sensor_;
  std::unique_ptr<MessageReader> reader_;
  SenderClock clock_;
  std::optional<std::uint64_t> last_;  // the sender's sequence
  std::int64_t taken_ns_ = 0;          // when the last sequence was accepted
  std::uint64_t sequence_ = 0;         // for slipd
  std::optional<Frame> pending_;       // without a clock: the last one that came
  mutable std::mutex mutex_;
  Account account_;  // by mutex_
  Writer writer_;
};

}  // namespace slipd::feed
