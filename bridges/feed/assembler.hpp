// Puts messages together from datagrams, as a profile describes their headers. No socket, no clock. One
// thread at a time; any bytes are valid input.
#pragma once

#include <cstdint>
#include <list>
#include <string>
#include <vector>

#include "bridges/feed/profile.hpp"
#include "bridges/feed_lane/message_reader.hpp"

namespace slipd::feed {

class Assembler {
 public:
  enum class Result : unsigned char { incomplete, message, corrupt };

  Assembler(const Datagrams& rule, bool has_head) : rule_(rule), has_head_(has_head) {}

  // A datagram of `sender`, whose messages are apart from those of others. `out` is valid until the next
  // call.
  Result put(const std::string& sender, Bytes datagram, Message& out);
  // Messages of which parts were missing when so many newer ones had begun that they were given up, or when
  // another message had their number.
  std::uint64_t lost() const noexcept { return lost_; }

 private:
  using Parts = std::vector<std::vector<std::uint8_t>>;
  struct Entry {
    std::string sender;
    std::uint64_t number = 0;
    Parts parts;  // empty: has not come; none is empty
    std::size_t come = 0;
    bool whole = false;  // has been; what comes of it now came twice
  };
  std::list<Entry>::iterator entry(const std::string& sender, std::uint64_t number);
  void give_up(const Entry& entry) noexcept;
  std::uint64_t count(const HeaderCount& where, Bytes datagram) const;

  Datagrams rule_;
  bool has_head_;
  std::list<Entry> entries_;  // of the last messages that began, the oldest first
  Parts parts_;               // of the last whole message
  std::vector<std::uint8_t> body_;
  std::uint64_t lost_ = 0;
};

}  // namespace slipd::feed
