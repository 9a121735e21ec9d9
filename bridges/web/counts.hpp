// What slipd-web has served and refused. Written in the serving thread; read there, for api/counts and the
// log.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace slipd::web {

enum class Count : std::uint8_t {
  connections,     // accepted
  too_many,        // closed at once: more connections, or live pages, than are allowed
  requests,        // answered
  refused_host,    // by Host
  refused_origin,  // by Origin
  refused_token,   // without the token
  refused_other,   // other methods, unknown targets
  malformed,       // no HTTP, or a head or body that is too long
  slow,            // closed because a head or an answer took too long
  live_pages,      // WebSockets that were opened
  bad_messages,    // WebSockets that were closed for what they sent
  messages,        // sent on WebSockets
  passed_over      // estimates and pictures that a browser was too slow for
};

class Counts {
 public:
  void add(Count which) noexcept { ++values_[static_cast<std::size_t>(which)]; }
  std::uint64_t of(Count which) const noexcept { return values_[static_cast<std::size_t>(which)]; }
  // {"connections":…, …}
  std::string json() const;

 private:
  std::array<std::uint64_t, 13> values_{};
};

}  // namespace slipd::web
