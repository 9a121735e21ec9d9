#include "tests/devices/misbehaviour.hpp"

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace slipd::devices {
namespace {

using Kind = Misbehaviour::Kind;
constexpr std::array<std::pair<std::string_view, Kind>, 10> kOrders{{{"lose", Kind::lose},
                                                                     {"reorder", Kind::reorder},
                                                                     {"repeat", Kind::repeat},
                                                                     {"garbage", Kind::garbage},
                                                                     {"shorten", Kind::shorten},
                                                                     {"lengthen", Kind::lengthen},
                                                                     {"stall", Kind::stall},
                                                                     {"unplug", Kind::unplug},
                                                                     {"plug", Kind::plug},
                                                                     {"quit", Kind::quit}}};

}  // namespace

std::string Misbehaviour::Order::text() const {
  const auto* named = std::ranges::find(kOrders, kind, &std::pair<std::string_view, Kind>::second);
  return std::string(named->first) + " " + std::to_string(scans);
}

Misbehaviour::Order Misbehaviour::parse(const std::string& text) {
  std::istringstream words(text);
  std::string verb, known;
  Order order;
  words >> verb;
  if (!(words >> order.scans)) order.scans = 1;
  for (const auto& [name, kind] : kOrders) {
    if (verb == name && order.scans > 0) order.kind = kind;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  if (order.kind == Kind::none)
    throw std::invalid_argument("'" + text + "' is none of: " + known + " [scans, from 1]");
  return order;
}

void Misbehaviour::distort(Kind kind, std::vector<Packet>& scan) {
  if (scan.empty()) return;
  const std::size_t victim = scan.size() / 2;
  Bytes& bytes = scan[victim].bytes;
  switch (kind) {
    case Kind::lose:
      scan.erase(scan.begin() + static_cast<std::ptrdiff_t>(victim));
      break;
    case Kind::reorder:
      std::ranges::reverse(scan);
      break;
    case Kind::repeat: {
      std::vector<Packet> twice;
      for (const Packet& packet : scan) twice.insert(twice.end(), 2, packet);
      scan = std::move(twice);
      break;
    }
    case Kind::garbage:
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random_());
      break;
    case Kind::shorten:
      bytes.resize(bytes.size() / 2);
      break;
    case Kind::lengthen:
      bytes.insert(bytes.end(), {0xA5, 0xA5, 0xA5});
      break;
    default:
      break;
  }
}

}  // namespace slipd::devices
