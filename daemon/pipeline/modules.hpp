// Finds, verifies and loads driver modules, slipd-driver-NAME.so, on demand. A module is never unloaded,
// because its threads and tables may be in use until the process ends.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/settings.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class DriverModules : public DriverCatalogue {
 public:
  // `given`: the folder of --driver-dir; none: the build tree's folder if the program runs from one, else the
  // installed one.
  explicit DriverModules(const std::optional<std::filesystem::path>& given = std::nullopt);

  // Loads the module if needed; null if it cannot be used.
  const DriverModule* find(const std::string& name) override;
  // Why find returned null, for people.
  std::string why_not(const std::string& name) override;
  // Names of the modules in the folder, usable or not, sorted.
  std::vector<std::string> names() override;
  // Forgets modules that could not be used, so that find tries them again.
  void forget_absent();
  // Where modules are.
  const std::filesystem::path& folder() const noexcept { return folder_; }

 private:
  struct Loaded {
    const DriverModule* module = nullptr;
    std::string trouble;  // why module is null
  };
  const Loaded& load(const std::string& name);
  // Why there is no module of this name, and what to install.
  std::string why_absent(const std::string& name);
  std::filesystem::path folder_;
  std::map<std::string, Loaded> loaded_;
};

// Why a file must not be loaded into the daemon; empty: it may be. `file` is an absolute path without
// symbolic links. It may be loaded if root or the daemon's user owns it and every folder above it, and no
// other user may write to any of them: then no other user can replace it between this check and its loading.
std::string why_untrusted(const std::filesystem::path& file);

}  // namespace slipd
