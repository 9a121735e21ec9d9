#include "daemon/notify.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>

#include <cinttypes>
#include <stdexcept>

#include "daemon/rt/clock.hpp"

namespace slipd::notify {

void ready() {
  sd_notify(0, "READY=1");
}

void reloading() {
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRId64, Now::read().monotonic_ns / 1000);
}

void stopping() {
  sd_notify(0, "STOPPING=1");
}

void watchdog() {
  sd_notify(0, "WATCHDOG=1");
}

std::optional<std::chrono::microseconds> watchdog_timeout() {
  std::uint64_t interval_us = 0;
  if (sd_watchdog_enabled(0, &interval_us) <= 0) return std::nullopt;
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
  sd_notifyf(0, "STATUS=%s", text.c_str());
  last = text;
}

std::optional<int> passed_socket() {
  const int count = sd_listen_fds(1);
  if (count <= 0) return std::nullopt;
  if (count > 1 || sd_is_socket_unix(SD_LISTEN_FDS_START, SOCK_STREAM, 1, nullptr, 0) <= 0) {
    throw std::runtime_error(
        "systemd passed something else than one listening Unix stream socket; see slipd.socket");
  }
  fcntl(SD_LISTEN_FDS_START, F_SETFL, fcntl(SD_LISTEN_FDS_START, F_GETFL) | O_NONBLOCK);
  return SD_LISTEN_FDS_START;
}

}  // namespace slipd::notify
