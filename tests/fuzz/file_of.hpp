// The bytes of one input as a file in memory, for readers that open files.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/fuzz/demand.hpp"

namespace slipd::fuzz {

// A regular file that holds these bytes until the next call.
inline std::filesystem::path file_of(const std::uint8_t* data, std::size_t size) {
  static const int fd = memfd_create("slipd-fuzz", MFD_CLOEXEC);
  demand(ftruncate(fd, 0) == 0 && pwrite(fd, data, size, 0) == static_cast<ssize_t>(size));
  return "/proc/self/fd/" + std::to_string(fd);
}

}  // namespace slipd::fuzz
