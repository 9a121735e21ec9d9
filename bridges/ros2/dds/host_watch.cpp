#include "bridges/ros2/dds/host_watch.hpp"

#include <sys/epoll.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "bridges/support/log.hpp"

namespace slipd::ros2 {

HostWatch::HostWatch(bridges::Loop& loop, const NodeOptions& options)
    : follows_(options.interfaces == std::vector<std::string>{kHost}),
      host_(host_interfaces()),
      watch_(loop, changes_.fd(), EPOLLIN, [this](std::uint32_t) { note(); }) {}

void HostWatch::note() {
  changes_.take();
  if (!follows_ || host_interfaces() == host_) return;
  bridges::log(bridges::LogLevel::notice, "this computer's addresses have changed: the node starts anew");
  kill(getpid(), SIGHUP);
}

}  // namespace slipd::ros2
