#include "daemon/notify.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <stdexcept>

#include "daemon/log/datagram.hpp"
#include "daemon/rt/clock.hpp"
#include "daemon/rt/environment.hpp"

namespace slipd::notify {
namespace {

constexpr int kFirstPassed = 3;  // SD_LISTEN_FDS_START

// Whether the variable names this process, to which its companions are then addressed.
bool names_us(const char* name) {
  return environment_variable(name) == std::to_string(getpid());
}

// sd_notify(3), "Standalone implementations".
void send(const std::string& text) {
  send_datagram(environment_variable("NOTIFY_SOCKET"), text, WhenFull::wait);
}

int option_of(int socket, int option) {
  int value = -1;
  socklen_t length = sizeof value;
  getsockopt(socket, SOL_SOCKET, option, &value, &length);
  return value;
}

}  // namespace

void ready() {
  send("READY=1");
}

void reloading() {
  constexpr std::int64_t kNsPerUs = 1000;
  send("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(Now::read().monotonic_ns / kNsPerUs));
}

void stopping() {
  send("STOPPING=1");
}

void watchdog() {
  send("WATCHDOG=1");
}

std::optional<std::chrono::microseconds> watchdog_timeout() {
  const std::int64_t interval_us = std::strtoll(environment_variable("WATCHDOG_USEC").c_str(), nullptr, 10);
  const bool for_another = !environment_variable("WATCHDOG_PID").empty() && !names_us("WATCHDOG_PID");
  if (interval_us <= 0 || for_another) return std::nullopt;
  return std::chrono::microseconds(interval_us);
}

void status(const ServiceContext& context, std::string& last) {
  std::size_t connected = 0;
  std::string absent;
  const std::int64_t now_ns = Now::read().monotonic_ns;
  for (const auto& status : context.board.sensors) {
    const std::string trouble = device_trouble(*status, status->facts(), now_ns);
    if (status->link.load(std::memory_order_relaxed) == DeviceLink::open && trouble.empty()) {
      ++connected;
      continue;
    }
    absent += (absent.empty() ? " (" : "; ") + status->name + (trouble.empty() ? "" : ": " + trouble);
  }
  const std::string text = std::to_string(connected) + " of " + std::to_string(context.board.sensors.size()) +
                           " sensors connected" + (absent.empty() ? "" : absent + ")") + ", " +
                           std::to_string(context.clients) + " clients";
  if (text == last) return;
  send("STATUS=" + text);
  last = text;
}

std::optional<int> passed_socket() {
  if (!names_us("LISTEN_PID")) return std::nullopt;
  const std::int64_t count = std::strtoll(environment_variable("LISTEN_FDS").c_str(), nullptr, 10);
  if (count <= 0) return std::nullopt;
  const bool listening_stream = option_of(kFirstPassed, SO_DOMAIN) == AF_UNIX &&
                                option_of(kFirstPassed, SO_TYPE) == SOCK_STREAM &&
                                option_of(kFirstPassed, SO_ACCEPTCONN) == 1;
  if (count > 1 || !listening_stream) {
    throw std::runtime_error(
        "systemd passed something else than one listening Unix stream socket; see slipd.socket");
  }
  fcntl(kFirstPassed, F_SETFD, FD_CLOEXEC);
  fcntl(kFirstPassed, F_SETFL, fcntl(kFirstPassed, F_GETFL) | O_NONBLOCK);
  return kFirstPassed;
}

}  // namespace slipd::notify
