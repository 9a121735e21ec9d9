// Messages to systemd (sd_notify) and socket activation, by the protocols that sd_notify(3) and
// sd_listen_fds(3) state, without libsystemd (daemon/log/journal.hpp says why). Without systemd all of it
// does nothing. Called from one thread: io.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "daemon/telemetry/service_context.hpp"

namespace slipd::notify {

// READY=1: start or reload is done.
void ready();
// RELOADING=1; ready() must follow.
void reloading();
// STOPPING=1.
void stopping();
// WATCHDOG=1.
void watchdog();

// The watchdog's timeout (WatchdogSec=); none: there is no watchdog.
std::optional<std::chrono::microseconds> watchdog_timeout();

// STATUS=, for `systemctl status`: how many sensors are connected, which are not and why, how many clients.
// Sent only if it differs from `last`, which is updated.
void status(const ServiceContext& context, std::string& last);

// The listening socket that systemd passed, not yet owned; none: it passed none. Throws std::runtime_error
// for anything but one listening Unix stream socket.
std::optional<int> passed_socket();

}  // namespace slipd::notify
