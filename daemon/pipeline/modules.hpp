// The driver modules, slipd-driver-NAME.so, found, judged and loaded on demand. Set-up thread only. A module
// stays loaded for the life of the process: its threads and tables may be in use until the end.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/settings.hpp"

namespace slipd {

class DriverModules : public DriverCatalogue {
 public:
  // `given`: --driver-dir. Without it the folder next to the program's own (a build tree's), else the
  // installed one.
  explicit DriverModules(const std::optional<std::filesystem::path>& given = std::nullopt);

  const DriverModule* find(const std::string& name) override;
  std::string why_not(const std::string& name) override;
  std::vector<std::string> names() override;  // of the modules that are there, loadable or not, sorted
  void forget_absent();                       // looks anew for those that could not be had before
  const std::filesystem::path& folder() const noexcept { return folder_; }

 private:
  struct Loaded {
    const DriverModule* module = nullptr;
    std::string trouble;  // why there is none
  };
  const Loaded& load(const std::string& name);
  std::filesystem::path folder_;
  std::map<std::string, Loaded> loaded_;
};

// Why a file, of an absolute path without links, must not be loaded into the daemon: empty if root or the
// daemon's own user owns it and every folder above it, and nobody else may write to any of them: then nobody
// can change it between this look and its loading.
std::string why_untrusted(const std::filesystem::path& file);

}  // namespace slipd
