// Where a program's shipped files are. Any thread.
#pragma once

#include <filesystem>
#include <string_view>

namespace slipd::bridges {

// The folder `name` beside that of this program, which a build tree has; else `installed`.
std::filesystem::path data_folder(std::string_view name, const std::filesystem::path& installed);

}  // namespace slipd::bridges
