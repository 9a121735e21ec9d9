#include "bridges/web/counts.hpp"

#include <string_view>

namespace slipd::web {

std::string Counts::json() const {
  static constexpr std::array<std::string_view, std::tuple_size_v<decltype(values_)>> kNames{
      "connections",   "too_many",      "requests",   "refused_host", "refused_origin",
      "refused_token", "refused_other", "malformed",  "slow",         "live_pages",
      "bad_messages",  "messages",      "passed_over"};
  std::string text;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    text += text.empty() ? "{\"" : ",\"";
    text.append(kNames[i]).append("\":").append(std::to_string(values_[i]));
  }
  return text + "}";
}

}  // namespace slipd::web
