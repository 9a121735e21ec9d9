// The log: on standard error for a person, with the time of day; under systemd to the journal, each line with
// its priority and, as fields that journalctl can ask for, whose it is (SLIPD_SENSOR) and whose doing
// (SLIPD_CAUSE). Set up once by main; written by normal threads. Real-time threads write to a LogRing, which
// io prints here, no more than a few times a minute where one says the same again and again.
#pragma once

#include <deque>
#include <string>
#include <string_view>

#include "daemon/log/log_limit.hpp"
#include "daemon/rt/log_ring.hpp"

namespace slipd {

// `level`: trace, debug, info, warning, error, as in the configuration. Before there are other threads.
void set_up_log(const std::string& level);

// Any thread, any time after that.
void change_log_level(const std::string& level);

// Any normal thread.
void say(LogLevel level, const About& about, std::string_view text);

// io: prints what the real-time threads have left.
void drain_logs(std::deque<LogRing>& rings, LogLimit& limit);

}  // namespace slipd
