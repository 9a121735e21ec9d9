// Loaded before a program (LD_PRELOAD). While the file that SLIPD_STALLED_DISK names is there, the disk takes
// nothing: fdatasync(2) does not return.
#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>

extern "C" int fdatasync(int fd) {
  using Function = int (*)(int);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "fdatasync"));
  constexpr useconds_t kBetweenLooks_us = 1000;
  const char* const file = std::getenv("SLIPD_STALLED_DISK");
  while (file != nullptr && access(file, F_OK) == 0) usleep(kBetweenLooks_us);
  return next(fd);
}
