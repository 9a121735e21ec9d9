// Real-time scheduling, CPU affinity and memory locking: what the configuration requests and what the system
// grants. Not called from a hot path.
#pragma once

#include <atomic>
#include <string>

#include "config/settings.hpp"

namespace slipd {

// What the system granted.
struct RealtimeGrant {
  // SCHED_FIFO with the requested priority.
  bool scheduling = false;
  // All memory, present and future, is locked.
  bool memory_locked = false;
  // Threads run on the requested CPUs only; false too if none were requested.
  bool cpus = false;
  // What was refused, why, and the remedy, for people; empty: nothing was refused.
  std::string refusal;
};

// Called from one thread: set-up, before it starts others. Locks memory if requested. Tries FIFO scheduling
// and CPU affinity on the calling thread and reverts both. With mode off it requests nothing.
RealtimeGrant request_realtime(const RealtimeSettings& settings);

// Called from each real-time thread, about itself. enter applies what was granted, leave returns to normal
// scheduling.
void enter_realtime(const RealtimeSettings& settings, const RealtimeGrant& grant) noexcept;
void leave_realtime(const RealtimeGrant& grant) noexcept;

}  // namespace slipd
