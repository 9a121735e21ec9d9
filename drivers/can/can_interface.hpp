// Why a CAN interface cannot be used, for people. The driver and slipd's own CAN messages share it.
#pragma once

#include <string>

namespace slipd::can {

// Error number for an interface that exists and is no CAN interface: "Protocol wrong type for socket".
// The kernel itself says ENODEV, as for one that does not exist.
int not_can_error() noexcept;

// 0 if the interface is one of a CAN bus, else the error number: ENODEV, not_can_error(), or what the kernel
// said. `fd`: a CAN socket. `interface`: at most 15 characters. Called from any thread; allocates nothing.
int check_can_interface(int fd, const std::string& interface) noexcept;

// What is wrong, and what to do; one line, to follow the interface's name. `error`: what making, configuring
// or binding a raw CAN socket failed with. Called from any thread; allocates nothing.
const char* why_no_can(int error) noexcept;

}  // namespace slipd::can
