// A message → one frame's values, as a profile describes it, or why it has none. No socket, no clock. One
// thread at a time; any bytes are valid input.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bridges/feed/profile.hpp"

namespace slipd::feed {

using Bytes = std::span<const std::uint8_t>;

// A whole message. `head` is empty unless the profile has one.
struct Message {
  Bytes head, body;
};

struct Reading {
  std::vector<float> values;              // taxels x axes, finite
  std::optional<std::uint64_t> sequence;  // of the sender
  std::optional<double> sent_s;           // on the sender's clock
};

enum class Outcome : unsigned char {
  frame,   // a Reading
  other,   // a message of another kind, of another sensor, or of a device that does not measure yet
  corrupt  // damaged, or of another layout
};

class Reader {
 public:
  explicit Reader(Profile profile) : profile_(std::move(profile)) {}

  // Fills `out` of a frame. Otherwise why() says what was wrong.
  Outcome read(const Message& message, Reading& out);
  // For people: what the last message that was no frame lacked.
  const std::string& why() const noexcept { return why_; }

 private:
  // Numbers at a place; false: there are none, or what is there is none.
  bool numbers_at(const Place& place, const nlohmann::json& document, Bytes body, std::size_t count,
                  std::vector<double>& out);
  bool numbers_in_bytes(const Place& place, Bytes bytes, std::size_t count, std::vector<double>& out);
  bool number_at(const Place& place, const nlohmann::json& document, Bytes body, double& out);
  Outcome refuse(Outcome outcome, std::string why);
  Outcome is_ours(const nlohmann::json& document, Bytes body);

  Profile profile_;
  std::string why_;
};

}  // namespace slipd::feed
