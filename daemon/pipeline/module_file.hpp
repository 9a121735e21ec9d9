// Verifies and loads one of slipd's modules: a driver, or the paper's method. A module is never unloaded,
// because its threads and tables may be in use until the process ends. Set-up; any thread.
#pragma once

#include <filesystem>
#include <string>

namespace slipd {

// Where modules are unless somebody says otherwise: the build tree's folder if the program runs from one,
// else the installed one.
std::filesystem::path default_module_folder();

// Why a file must not be loaded into the daemon; empty: it may be. `file` is an absolute path without
// symbolic links. It may be loaded if root or the daemon's user owns it and every folder above it, and no
// other user may write to any of them: then no other user can replace it between this check and its loading.
std::string why_untrusted(const std::filesystem::path& file);

struct ModuleFile {
  void* library = nullptr;  // of dlopen
  std::string trouble;      // why it is null, for people
};
ModuleFile load_module_file(const std::filesystem::path& file);

}  // namespace slipd
