// Log lines of a bridge, for the journal: `<N>text` on stderr, N as in sd-daemon(3). On a terminal without
// the prefix. Any thread; the level is set before there are several.
#pragma once

#include <string_view>

namespace slipd::bridges {

// Severity, with the numbers of syslog(3).
enum class LogLevel : int { error = 3, warning = 4, notice = 5, info = 6, debug = 7 };

// Writes one line. Control characters are escaped, so that text from a peer cannot forge a line.
void log(LogLevel level, std::string_view text);

// Lines of lower importance than `most` are left out. The default is info.
void set_log_level(LogLevel most) noexcept;

}  // namespace slipd::bridges
