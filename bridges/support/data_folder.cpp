#include "bridges/support/data_folder.hpp"

#include <system_error>

namespace slipd::bridges {

std::filesystem::path data_folder(std::string_view name, const std::filesystem::path& installed) {
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const auto beside = program.parent_path().parent_path() / name;
  return std::filesystem::is_directory(beside, unknown) ? beside : installed;
}

}  // namespace slipd::bridges
