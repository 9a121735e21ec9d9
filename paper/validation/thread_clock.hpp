// Time of the calling thread on the processor: what the others on the machine take is not counted. For
// measuring methods; any thread.
#pragma once

#include <time.h>

namespace slipd {

inline double thread_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace slipd
