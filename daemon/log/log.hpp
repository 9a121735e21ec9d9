// The log. Under systemd it goes to the journal, each line with its priority and the fields SLIPD_SENSOR (the
// sensor's name) and SLIPD_CAUSE (see Cause). Otherwise it goes to standard error with the time of day.
// Normal threads write directly. Real-time threads write into a LogRing that io prints, with repeated lines
// limited by LogLimit.
#pragma once

#include <list>
#include <string>
#include <string_view>

#include "daemon/log/log_limit.hpp"
#include "daemon/rt/log_ring.hpp"

namespace slipd {

// Called from one thread: main's, before there are others. `level`: trace, debug, info, warning or error.
void set_up_log(const std::string& level);

// Called from any thread that may lock, after set_up_log.
void change_log_level(const std::string& level);

// Called from any thread that may lock and allocate.
void write_log(LogLevel level, const LogContext& context, std::string_view text);

// Called from one thread: io. Prints all lines in the rings, as far as `limit` admits them, and what `limit`
// suppressed in windows that are over.
void drain_logs(std::list<LogRing>& rings, LogLimit& limit);

}  // namespace slipd
