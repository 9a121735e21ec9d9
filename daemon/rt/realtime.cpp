#include "daemon/rt/realtime.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <system_error>

namespace slipd {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

int set_fifo(int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
}

int set_other() noexcept {
  const sched_param parameters{};
  return pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameters);
}

int set_cpus(const std::vector<int>& cpus) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) {
    if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
    CPU_SET(static_cast<std::size_t>(cpu), &set);
  }
  return pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

void note(std::string& all, const std::string& one) {
  all += (all.empty() ? "" : "; ") + one;
}

}  // namespace

RealtimeGrant request_realtime(const RealtimeSettings& settings) {
  RealtimeGrant grant;
  if (settings.mode == RealtimeMode::off) return grant;
  if (const int error = set_fifo(settings.priority); error == 0) {
    grant.scheduling = true;
    set_other();
  } else {
    note(grant.refusal,
         "SCHED_FIFO " + std::to_string(settings.priority) + ": " + reason(error) +
             " (install slipd-realtime; outside the service: an rtprio limit or CAP_SYS_NICE)");
  }
  if (!settings.cpus.empty()) {
    cpu_set_t before;
    pthread_getaffinity_np(pthread_self(), sizeof before, &before);
    if (const int error = set_cpus(settings.cpus); error == 0) {
      grant.cpus = true;
      pthread_setaffinity_np(pthread_self(), sizeof before, &before);
    } else {
      note(grant.refusal,
           "realtime.cpus: " + reason(error) + " (are they there, and allowed for this process?)");
    }
  }
  if (settings.lock_memory) {
    // Freed memory is not returned to the system, so that it need not be mapped and locked again.
    mallopt(M_TRIM_THRESHOLD, -1);  // NOLINT(concurrency-mt-unsafe): before any other thread
    // One arena: each further one would lock 64 MB, and no real-time thread allocates.
    mallopt(M_ARENA_MAX, 1);  // NOLINT(concurrency-mt-unsafe): as above
    if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
      grant.memory_locked = true;
    } else {
      note(grant.refusal,
           "locking memory: " + reason(errno) +
               " (install slipd-realtime; outside the service: a memlock limit or CAP_IPC_LOCK)");
    }
  }
  return grant;
}

void enter_realtime(const RealtimeSettings& settings, const RealtimeGrant& grant) noexcept {
  if (grant.cpus) set_cpus(settings.cpus);
  if (grant.scheduling) set_fifo(settings.priority);
}

void leave_realtime(const RealtimeGrant& grant) noexcept {
  if (grant.scheduling) set_other();
}

}  // namespace slipd
