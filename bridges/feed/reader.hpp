// A message → one frame's values, as a profile describes it, or why it has none. No socket, no clock. One
// thread at a time; any bytes are valid input.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <utility>
#include <vector>

#include "bridges/feed/profile.hpp"
#include "bridges/feed_lane/message_reader.hpp"

namespace slipd::feed {

class Reader final : public MessageReader {
 public:
  explicit Reader(Profile profile) : profile_(std::move(profile)) {}

  Outcome read(const Message& message, Reading& out) override;

 private:
  // Numbers at a place; false: there are none, or what is there is none.
  bool numbers_at(const Place& place, const nlohmann::json& document, Bytes body, std::size_t count,
                  std::vector<double>& out);
  bool numbers_in_bytes(const Place& place, Bytes bytes, std::size_t count, std::vector<double>& out);
  bool number_at(const Place& place, const nlohmann::json& document, Bytes body, double& out);
  Outcome is_ours(const nlohmann::json& document, Bytes body);

  Profile profile_;
};

}  // namespace slipd::feed
