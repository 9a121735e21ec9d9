// Finds and loads driver modules, slipd-driver-NAME.so, on demand (module_file.hpp).
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
  // `given`: the folder of --driver-dir; none: default_module_folder().
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

}  // namespace slipd
