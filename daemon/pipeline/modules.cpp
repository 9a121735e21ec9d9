#include "daemon/pipeline/modules.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <system_error>

#include "daemon/pipeline/module_file.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;
constexpr const char* kPrefix = "slipd-driver-";
constexpr const char* kSuffix = ".so";
// Drivers that have a Debian package of their own, which is called as the module is.
constexpr std::string_view kPackagedApart[] = {"usb", "hid", "modbus", "serial", "can"};

}  // namespace

DriverModules::DriverModules(const std::optional<fs::path>& given)
    : folder_(fs::absolute(given ? *given : default_module_folder())) {}

const DriverModules::Loaded& DriverModules::load(const std::string& name) {
  if (const auto known = loaded_.find(name); known != loaded_.end()) return known->second;
  Loaded& entry = loaded_[name];
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  if (name.empty() || !std::all_of(name.begin(), name.end(), allowed)) {
    entry.trouble = "a driver's name has only a-z, 0-9, - and _";
    return entry;
  }
  const fs::path file = folder_ / (kPrefix + name + kSuffix);
  std::error_code error;
  if (!fs::exists(file, error)) {
    entry.trouble = why_absent(name);
    return entry;
  }
  const ModuleFile loaded = load_module_file(file);
  entry.trouble = loaded.trouble;
  if (loaded.library == nullptr) return entry;
  using Entry = const DriverModule* (*)();
  const auto symbol = reinterpret_cast<Entry>(dlsym(loaded.library, kDriverSymbol));
  const DriverModule* module = symbol != nullptr ? symbol() : nullptr;
  if (module == nullptr) {
    entry.trouble = file.string() + " is no slipd driver: it lacks the symbol " + kDriverSymbol;
  } else if (module->abi != kDriverAbi) {
    entry.trouble = file.string() + " was built for driver interface " + std::to_string(module->abi) +
                    ", this slipd has " + std::to_string(kDriverAbi) + ": build it anew against this slipd";
  } else if (module->name != name) {
    entry.trouble = file.string() + " calls itself \"" + module->name + "\": name the file after it";
  } else {
    entry.module = module;
  }
  return entry;
}

std::string DriverModules::why_absent(const std::string& name) {
  std::string there;
  for (const std::string& each : names()) there += (there.empty() ? "" : ", ") + each;
  const std::string installed =
      "installed are: " + (there.empty() ? "none" : there) + ", in " + folder_.string();
  if (std::ranges::find(kPackagedApart, name) != std::end(kPackagedApart))
    return "it is not installed: install the package " + std::string(kPrefix) + name + "; " + installed;
  return "there is no such driver; " + installed;
}

const DriverModule* DriverModules::find(const std::string& name) {
  return load(name).module;
}

std::string DriverModules::why_not(const std::string& name) {
  return load(name).trouble;
}

void DriverModules::forget_absent() {
  std::erase_if(loaded_, [](const auto& entry) { return entry.second.module == nullptr; });
}

std::vector<std::string> DriverModules::names() {
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& item : fs::directory_iterator(folder_, error)) {
    const std::string file = item.path().filename().string();
    if (file.starts_with(kPrefix) && file.ends_with(kSuffix)) {
      found.push_back(file.substr(std::char_traits<char>::length(kPrefix),
                                  file.size() - std::char_traits<char>::length(kPrefix) - 3));
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace slipd
