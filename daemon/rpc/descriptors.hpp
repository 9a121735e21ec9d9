// Room for descriptors: as many as the clients that may come need, and those of clients where they are in
// nobody's way. io thread.
#pragma once

#include <cstddef>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// Raises the process's own limit as far as so many clients need it and the system lets it; says so in the log
// where that is not enough.
void make_room_for(std::size_t clients);

// The same file under a number that select() cannot take, where the limit has such numbers: libraries of
// drivers that wait by select(), as libmodbus does, write past their memory with one of 1024 or more, and so
// must always find lower ones free, however many clients there are.
UniqueFd out_of_the_way(UniqueFd file) noexcept;

}  // namespace slipd
