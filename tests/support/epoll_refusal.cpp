// Loaded before a program (LD_PRELOAD). Once the file that SLIPD_EPOLL_REFUSAL names is there, the system has
// no room for another descriptor to wait for (ENOSPC of epoll_ctl(2)): an event loop cannot go on without.
#include <dlfcn.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

extern "C" int epoll_ctl(int epoll, int what, int fd, epoll_event* event) noexcept {
  using Function = int (*)(int, int, int, epoll_event*);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "epoll_ctl"));
  const char* const file = std::getenv("SLIPD_EPOLL_REFUSAL");
  if (what == EPOLL_CTL_ADD && file != nullptr && access(file, F_OK) == 0) {
    errno = ENOSPC;
    return -1;
  }
  return next(epoll, what, fd, event);
}
