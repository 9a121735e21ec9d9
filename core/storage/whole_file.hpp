// Files that only slipd writes. Writing one so that it is the old one or the new one, whole, at any time:
// whatever else is cut short, power included. Takes as long as the disk does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace slipd {

// Writes beside the file, syncs, and renames; makes the folder. `mode`: of the file, whatever the umask.
// Throws std::runtime_error, which names the file.
void write_whole_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes,
                      unsigned mode = 0644);

// What write_whole_file wrote, by us or by root: all of the file. Throws std::runtime_error, which names the
// file, for one that cannot be read, is a symbolic link or no regular file, belongs to somebody else, may be
// written by everybody, or is larger than `most` bytes.
std::vector<std::uint8_t> read_own_file(const std::filesystem::path& file, std::size_t most);

}  // namespace slipd
