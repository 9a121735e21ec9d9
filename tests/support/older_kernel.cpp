// Loaded before a program (LD_PRELOAD). The system has no SO_PASSRIGHTS, as before Linux 6.16: whoever has a
// connection may pass descriptors on it.
#include <dlfcn.h>
#include <sys/socket.h>

#include <cerrno>

#include "core/storage/descriptor_passing.hpp"

namespace {

bool unknown(int level, int option) noexcept {
  if (level != SOL_SOCKET || option != slipd::kPassRights) return false;
  errno = ENOPROTOOPT;
  return true;
}

}  // namespace

extern "C" int setsockopt(int socket, int level, int option, const void* value, socklen_t length) noexcept {
  using Function = int (*)(int, int, int, const void*, socklen_t);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "setsockopt"));
  return unknown(level, option) ? -1 : next(socket, level, option, value, length);
}

extern "C" int getsockopt(int socket, int level, int option, void* value, socklen_t* length) noexcept {
  using Function = int (*)(int, int, int, void*, socklen_t*);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "getsockopt"));
  return unknown(level, option) ? -1 : next(socket, level, option, value, length);
}
