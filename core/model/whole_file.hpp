// Writing a file so that it is the old one or the new one, whole, at any time: whatever else is cut short,
// power included. Takes as long as the disk does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace slipd {

// Writes beside the file, syncs, and renames; makes the folder. `mode`: of the file, whatever the umask.
// Throws std::runtime_error, which names the file.
void write_whole_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes,
                      unsigned mode = 0644);

}  // namespace slipd
