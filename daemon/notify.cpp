#include "daemon/notify.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "core/storage/unique_fd.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd::notify {
namespace {

constexpr int kFirstPassed = 3;  // SD_LISTEN_FDS_START

// Of the environment; empty: it is not set. systemd sets none of these later, and nobody else sets any.
std::string variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value == nullptr ? "" : value;
}

// Whether the variable names this process, to which its companions are then addressed.
bool names_us(const char* name) {
  return variable(name) == std::to_string(getpid());
}

// sd_notify(3), "Standalone implementations": a datagram to NOTIFY_SOCKET, where @ begins an abstract
// address.
void send(const std::string& text) {
  const std::string to = variable("NOTIFY_SOCKET");
  sockaddr_un address{};
  if (to.size() < 2 || to.size() >= sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::memcpy(static_cast<char*>(address.sun_path), to.data(), to.size());
  if (to.front() == '@') address.sun_path[0] = '\0';
  const UniqueFd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sendto(socket.get(), text.data(), text.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address),
         static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + to.size()));
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
  const std::int64_t interval_us = std::strtoll(variable("WATCHDOG_USEC").c_str(), nullptr, 10);
  const bool for_another = !variable("WATCHDOG_PID").empty() && !names_us("WATCHDOG_PID");
  if (interval_us <= 0 || for_another) return std::nullopt;
  return std::chrono::microseconds(interval_us);
}

void status(const ServiceContext& context, std::string& last) {
  std::size_t connected = 0;
  std::string absent;
  for (const auto& status : context.board.sensors) {
    const std::string trouble = status->facts().trouble;
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
  const std::int64_t count = std::strtoll(variable("LISTEN_FDS").c_str(), nullptr, 10);
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
