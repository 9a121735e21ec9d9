// The kernel's figures of a running process: memory, descriptors, threads.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>

namespace slipd::testing {

// Of its own memory, without pages of files, which the kernel drops and reads again.
std::size_t resident_kb(pid_t process);
std::size_t open_descriptors(pid_t process);
std::size_t threads(pid_t process);

// The kernel's list of the files that it has mapped, such as libraries.
std::string mapped_by(pid_t process);

// The process's running child; 0: none.
pid_t child_of(pid_t process);

}  // namespace slipd::testing
