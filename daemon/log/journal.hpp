// Lines with fields for journald, in its native protocol (systemd.io/JOURNAL_NATIVE_PROTOCOL): a datagram.
// Without libsystemd, whose six libraries for compressing and signing journals slipd would lock into memory
// unused.
#pragma once

#include <string>
#include <string_view>

namespace slipd {

class JournalEntry {
 public:
  // `field`: capital letters, digits and _, as MESSAGE, PRIORITY, SYSLOG_IDENTIFIER. `value` may have several
  // lines.
  JournalEntry& add(std::string_view field, std::string_view value);
  // What has been added, as journald reads it.
  const std::string& bytes() const noexcept { return bytes_; }

 private:
  std::string bytes_;
};

// Where journald reads entries, a datagram each.
inline constexpr const char* kJournald = "/run/systemd/journal/socket";

}  // namespace slipd
