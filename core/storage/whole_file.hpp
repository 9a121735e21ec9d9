// Reads and replaces files that only slipd writes. A replaced file is at any time either the old or the new
// one, also after a crash or a loss of power. Called from any thread that may wait for the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace slipd {

// Writes a temporary file in the same folder, syncs it and renames it. Creates the folder. `mode` is the
// file's permissions, independent of the umask. Throws std::runtime_error, which names the file.
void write_whole_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes,
                      unsigned mode = 0644);

// All bytes of a file that slipd or root wrote. Throws std::runtime_error, which names the file, if it cannot
// be read, is a symbolic link or no regular file, belongs to another user, is writable by everybody, or is
// larger than `most` bytes.
std::vector<std::uint8_t> read_own_file(const std::filesystem::path& file, std::size_t most);

}  // namespace slipd
