// What slipd tells systemd of itself; without systemd all of it does nothing. io thread.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "daemon/telemetry/service_context.hpp"

namespace slipd::notify {

void ready();
void reloading();  // ends with ready()
void stopping();
void alive();  // for the watchdog

// How long the watchdog waits at most; none: there is none.
std::optional<std::chrono::microseconds> watchdog_patience();

// For `systemctl status`: how many sensors are connected, which are not and why, how many clients. Said anew
// only when it has changed since `last`, which is updated.
void status(const ServiceContext& context, std::string& last);

// The socket that systemd listens on for us; none: it does not. Throws std::runtime_error for something else
// than one listening Unix stream socket.
std::optional<int> passed_socket();

}  // namespace slipd::notify
