// Opens and reads files that somebody else wrote, where only a regular file is meant. A pipe or a device that
// lies in its place is refused; opening it would wait for its other end. Called from any thread that may wait
// for the disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// Opens `file` for reading; links are followed. Throws std::system_error, whose what() begins with the file's
// name and says what lies there instead if it is no regular file.
UniqueFd open_regular_file(const std::filesystem::path& file);

// All bytes of `file`. Throws std::system_error as open_regular_file, and with file_too_large for more than
// `most` bytes.
std::string read_regular_file(const std::filesystem::path& file, std::size_t most);

}  // namespace slipd
