#include "bridges/feed/assembler.hpp"

#include <algorithm>
#include <utility>

namespace slipd::feed {
namespace {

// Messages of which parts are awaited. Fewer: datagrams that overtake each other lose messages. More: memory,
// and messages that lost a part are counted later.
constexpr std::size_t kMostOpen = 8;
// Parts of a message. Fewer: large frames are refused. More: memory for a hostile sender.
constexpr std::size_t kMostParts = 256;

}  // namespace

std::uint64_t Assembler::count(const HeaderCount& where, Bytes datagram) const {
  return wire::read_bits(datagram.data() + where.offset, where.type.bytes, where.type.big_endian);
}

std::list<Assembler::Open>::iterator Assembler::open(const std::string& sender, std::uint64_t number,
                                                     std::size_t parts) {
  const auto same = [&](const Open& one) { return one.number == number && one.sender == sender; };
  if (const auto found = std::ranges::find_if(open_, same); found != open_.end()) return found;
  if (open_.size() == kMostOpen) {
    open_.pop_front();
    ++lost_;
  }
  return open_.insert(open_.end(), Open{sender, number, std::vector<std::vector<std::uint8_t>>(parts), 0});
}

Assembler::Result Assembler::put(const std::string& sender, Bytes datagram, Message& out) {
  if (datagram.size() <= rule_.header) return Result::corrupt;
  const std::uint64_t number = count(rule_.message, datagram);
  const std::uint64_t part = count(rule_.part, datagram), last = count(rule_.last, datagram);
  if (last >= kMostParts || part > last || (has_head_ && last == 0)) return Result::corrupt;
  const auto message = open(sender, number, last + 1);
  if (message->parts.size() != last + 1) return Result::corrupt;
  std::vector<std::uint8_t>& place = message->parts[part];
  if (!place.empty()) return Result::corrupt;  // twice
  place.assign(datagram.begin() + static_cast<std::ptrdiff_t>(rule_.header), datagram.end());
  if (++message->come <= last) return Result::incomplete;

  whole_ = std::move(*message);
  open_.erase(message);
  body_.clear();
  for (std::size_t i = has_head_ ? 1 : 0; i < whole_.parts.size(); ++i)
    body_.insert(body_.end(), whole_.parts[i].begin(), whole_.parts[i].end());
  out = {has_head_ ? Bytes(whole_.parts.front()) : Bytes(), body_};
  return Result::message;
}

}  // namespace slipd::feed
