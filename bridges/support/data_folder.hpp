// Where a program's shipped files are. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace slipd::bridges {

// The folder `name` beside that of this program, which a build tree has; else `installed`.
std::filesystem::path data_folder(std::string_view name, const std::filesystem::path& installed);

// The first NAME.json that is in one of the folders; a name with a slash is the path of the file itself.
// Throws SettingsError, which says where it has looked.
std::filesystem::path profile_file(const std::string& name,
                                   const std::vector<std::filesystem::path>& folders);

}  // namespace slipd::bridges
