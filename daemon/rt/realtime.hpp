// What real time was asked for and what the system granted. Nothing here is called in the hot path.
#pragma once

#include <atomic>
#include <string>

#include "config/settings.hpp"

namespace slipd {

struct RealtimeGrant {
  bool scheduling = false;  // SCHED_FIFO
  bool memory_locked = false;
  bool cpus = false;    // threads kept on the CPUs asked for; false also if none were asked for
  std::string refusal;  // what was refused, why, and the remedy; empty: nothing
};

// Set-up thread, before the others: locks memory if asked for, and tries on itself whether FIFO scheduling
// and the CPUs would be granted (and lets go of them again). With mode off nothing is asked.
RealtimeGrant ask_for_realtime(const RealtimeSettings& settings);

// The calling thread takes on (or puts off) what was granted.
void enter_realtime(const RealtimeSettings& settings, const RealtimeGrant& grant) noexcept;
void leave_realtime(const RealtimeGrant& grant) noexcept;

}  // namespace slipd
