// What a lane knows of messages: a reader makes one frame's values of each, or says why it has none.
// slipd-feed and slipd-feed-ros2 have readers of their own. One thread at a time; any bytes are valid input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace slipd::feed {

using Bytes = std::span<const std::uint8_t>;

// A whole message. `head` is empty unless the profile has one.
struct Message {
  Bytes head, body;
  std::optional<std::int64_t> sent_ns = {};  // on the sender's clock, by what carried the message
};

struct Reading {
  std::vector<float> values;              // taxels x axes, finite
  std::optional<std::uint64_t> sequence;  // of the sender; a message whose sequence does not rise is no frame
  std::size_t sequence_bytes = 8;         // in which the sender counts, and wraps
  bool counted = true;                    // a jump of the sequence by n is n - 1 lost messages
  std::optional<double> sent_s;           // on the sender's clock
  double sent_range_s = 0;                // after which the sender's clock wraps; 0: it does not
};

enum class Outcome : unsigned char {
  frame,   // a Reading
  other,   // a message of another kind, of another sensor, or of a device that does not measure yet
  corrupt  // damaged, or of another layout
};

class MessageReader {
 public:
  MessageReader() = default;
  MessageReader(const MessageReader&) = delete;
  MessageReader& operator=(const MessageReader&) = delete;
  virtual ~MessageReader() = default;

  // Fills `out` of a frame. Otherwise why() says what was wrong.
  virtual Outcome read(const Message& message, Reading& out) = 0;
  // For people: what the last message that was no frame lacked.
  const std::string& why() const noexcept { return why_; }

 protected:
  Outcome refuse(Outcome outcome, std::string why) {
    why_ = std::move(why);
    return outcome;
  }

 private:
  std::string why_;
};

}  // namespace slipd::feed
