#include "bridges/feed/address.hpp"

#include <regex>

namespace slipd::feed {

std::optional<Address> address_of(const std::string& text) {
  static const std::regex kForm("(udp|ws)://([A-Za-z0-9.-]+):([0-9]{1,5})(/[!-~]*)?");
  constexpr unsigned long kLargestPort = 65535;
  std::smatch found;
  if (!std::regex_match(text, found, kForm)) return std::nullopt;
  const unsigned long port = std::stoul(found[3]);
  const bool udp = found[1] == "udp";
  if (port == 0 || port > kLargestPort || (udp && found[4].matched)) return std::nullopt;
  return Address{udp ? Scheme::udp : Scheme::websocket, found[2], static_cast<std::uint16_t>(port),
                 found[4].matched ? std::string(found[4]) : "/"};
}

}  // namespace slipd::feed
