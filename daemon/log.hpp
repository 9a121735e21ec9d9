// The log: lines on standard error, for a person with the time of day, for journald with its level instead.
// Set up once by main; written by io and set-up threads. Real-time threads write to a LogRing, which io
// prints here.
#pragma once

#include <string>

#include "daemon/board/board.hpp"

namespace slipd {

// `level`: trace, debug, info, warning, error, as in the configuration.
void set_up_log(const std::string& level);

// Any thread, any time after that.
void change_log_level(const std::string& level);

// io: prints what the real-time threads have left.
void drain_logs(Board& board);

}  // namespace slipd
