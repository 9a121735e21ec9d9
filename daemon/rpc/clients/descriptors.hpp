// File descriptors: a limit that is high enough for all clients, and high numbers for clients. Called from
// one thread: io.
#pragma once

#include <cstddef>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// Raises the process's limit (RLIMIT_NOFILE) for so many clients, as far as the system allows. Logs a warning
// if that is not enough.
void make_room_for(std::size_t clients);

// Moves `file` to a number of at least FD_SETSIZE if the limit allows it; otherwise returns it unchanged.
// Drivers' libraries that wait by select(), such as libmodbus, corrupt memory with numbers of FD_SETSIZE or
// more, so lower ones must stay free for them.
UniqueFd out_of_the_way(UniqueFd file) noexcept;

}  // namespace slipd
