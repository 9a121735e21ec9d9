#include "daemon/rpc/clients/descriptors.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/select.h>

#include <algorithm>
#include <string>

#include "daemon/log/log.hpp"

namespace slipd {
namespace {

constexpr rlim_t kOwn = 128;       // slipd's own sockets, devices, files and recordings, with a reserve
constexpr rlim_t kEachClient = 2;  // its connection, and one that it gets

}  // namespace

void make_room_for(std::size_t clients) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  rlim_t needed = kOwn + kEachClient * clients;
  if (needed > FD_SETSIZE) needed += FD_SETSIZE;  // see out_of_the_way
  if (limit.rlim_cur < needed) {
    limit.rlim_cur = std::min(needed, limit.rlim_max);
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  if (limit.rlim_cur < kOwn + clients) {
    write_log(
        LogLevel::warning, {{}, Cause::machine},
        "socket.max_clients is " + std::to_string(clients) + ", but slipd may open no more than " +
            std::to_string(limit.rlim_cur) +
            " files: clients beyond that wait to be let in; raise LimitNOFILE, or lower socket.max_clients");
  }
}

UniqueFd out_of_the_way(UniqueFd file) noexcept {
  if (file.get() >= FD_SETSIZE) return file;
  UniqueFd moved(fcntl(file.get(), F_DUPFD_CLOEXEC, FD_SETSIZE));
  return moved ? std::move(moved) : std::move(file);
}

}  // namespace slipd
