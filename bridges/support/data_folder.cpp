#include "bridges/support/data_folder.hpp"

#include <system_error>

#include "schema/settings_error.hpp"

namespace slipd::bridges {

std::filesystem::path data_folder(std::string_view name, const std::filesystem::path& installed) {
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const auto beside = program.parent_path().parent_path() / name;
  return std::filesystem::is_directory(beside, unknown) ? beside : installed;
}

std::filesystem::path profile_file(const std::string& name,
                                   const std::vector<std::filesystem::path>& folders) {
  const bool is_path = name.find('/') != std::string::npos;
  std::string looked;
  for (const std::filesystem::path& folder : is_path ? std::vector<std::filesystem::path>{""} : folders) {
    std::filesystem::path file = is_path ? std::filesystem::path(name) : folder / (name + ".json");
    std::error_code error;
    if (std::filesystem::exists(file, error)) return file;
    looked += (looked.empty() ? "" : ", ") + file.string();
  }
  throw SettingsError({"there is no profile \"" + name + "\"; looked for " + looked});
}

}  // namespace slipd::bridges
