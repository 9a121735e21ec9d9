// Where messages come from, as settings and profiles write it. Any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace slipd::feed {

enum class Scheme : unsigned char { udp, websocket };

struct Address {
  Scheme scheme = Scheme::udp;
  std::string host;  // udp: the address to listen on; ws: the server
  std::uint16_t port = 0;
  std::string path = "/";  // of a WebSocket
  bool operator==(const Address&) const = default;
};

// Of "udp://127.0.0.1:9988" or "ws://localhost:5000/path"; none: it is no such address.
std::optional<Address> address_of(const std::string& text);

}  // namespace slipd::feed
