#include "bridges/feed/assembler.hpp"

#include <algorithm>
#include <utility>

namespace slipd::feed {
namespace {

// The last messages that began; of those before, no parts are awaited. Fewer: datagrams that overtake each
// other lose messages. More: memory, and messages that lost a part are counted later.
constexpr std::size_t kMostEntries = 8;
// Parts of a message. Fewer: large frames are refused. More: memory for a hostile sender.
constexpr std::size_t kMostParts = 256;

}  // namespace

std::uint64_t Assembler::count(const HeaderCount& where, Bytes datagram) const {
  return wire::read_bits(datagram.data() + where.offset, where.type.bytes, where.type.big_endian);
}

void Assembler::give_up(const Entry& entry) noexcept {
  if (!entry.whole) ++lost_;
}

std::list<Assembler::Entry>::iterator Assembler::entry(const std::string& sender, std::uint64_t number) {
  const auto same = [&](const Entry& one) { return one.number == number && one.sender == sender; };
  if (const auto found = std::ranges::find_if(entries_, same); found != entries_.end()) return found;
  if (entries_.size() == kMostEntries) {
    give_up(entries_.front());
    entries_.pop_front();
  }
  return entries_.insert(entries_.end(), Entry{sender, number, {}});
}

Assembler::Result Assembler::put(const std::string& sender, Bytes datagram, Message& out) {
  if (datagram.size() <= rule_.header) return Result::corrupt;
  const std::uint64_t number = count(rule_.message, datagram);
  const std::uint64_t part = count(rule_.part, datagram), last = count(rule_.last, datagram);
  if (last >= kMostParts || part > last || (has_head_ && last == 0)) return Result::corrupt;
  const auto message = entry(sender, number);
  if (message->come == 0) message->parts.resize(last + 1);
  if (message->parts.size() != last + 1) return Result::corrupt;
  const Bytes content = datagram.subspan(rule_.header);
  if (const auto& before = message->parts[part]; !before.empty()) {
    if (std::ranges::equal(before, content)) return Result::corrupt;  // twice
    // Another message of the same number, such as of a sender that began anew.
    give_up(*message);
    *message = {sender, number, Parts(last + 1)};
    entries_.splice(entries_.end(), entries_, message);
  }
  message->parts[part].assign(content.begin(), content.end());
  if (++message->come <= last) return Result::incomplete;

  message->whole = true;
  message->come = 0;
  parts_ = std::exchange(message->parts, {});
  body_.clear();
  for (std::size_t i = has_head_ ? 1 : 0; i < parts_.size(); ++i)
    body_.insert(body_.end(), parts_[i].begin(), parts_[i].end());
  out = {has_head_ ? Bytes(parts_.front()) : Bytes(), body_};
  return Result::message;
}

}  // namespace slipd::feed
