#include "daemon/pipeline/modules.hpp"

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <string_view>
#include <system_error>

#include "core/storage/regular_file.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;
constexpr const char* kPrefix = "slipd-driver-";
constexpr const char* kSuffix = ".so";
// Drivers that have a Debian package of their own, which is called as the module is.
constexpr std::string_view kPackagedApart[] = {"usb", "hid", "modbus", "can"};

fs::path default_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  fs::path beside = program.parent_path().parent_path() / "drivers";
  if (!error && fs::is_directory(beside, error)) return beside;
  return SLIPD_INSTALLED_DRIVERS;
}

std::string why_untrusted_one(const fs::path& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) {
    return path.string() + ": " + std::generic_category().message(errno);
  }
  if (status.st_uid != 0 && status.st_uid != geteuid()) {
    return path.string() + " belongs to user " + std::to_string(status.st_uid) +
           ": only root or slipd's own user may own it; use chown";
  }
  // In a sticky folder such as /tmp a user can replace only their own files.
  if (S_ISDIR(status.st_mode) && (status.st_mode & S_ISVTX) != 0) return {};
  if ((status.st_mode & S_IWOTH) != 0) return path.string() + " can be written by everybody: use chmod o-w";
  if ((status.st_mode & S_IWGRP) != 0 && status.st_gid != 0 && status.st_gid != getegid()) {
    return path.string() + " can be written by group " + std::to_string(status.st_gid) +
           ", which is not slipd's own: use chmod g-w";
  }
  return {};
}

// Whether all segments are within the file. The loader does not check this: a file that was cut (by a full
// disk, say) would crash the process.
bool is_whole(int fd) {
  const auto read_at = [fd](std::uint64_t offset, auto& out) {
    return pread(fd, &out, sizeof out, static_cast<off_t>(offset)) == static_cast<ssize_t>(sizeof out);
  };
  ElfW(Ehdr) header{};
  struct stat status {};
  if (fstat(fd, &status) != 0 || !read_at(0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
      header.e_phentsize != sizeof(ElfW(Phdr))) {
    return false;
  }
  const auto size = static_cast<std::uint64_t>(status.st_size);
  for (unsigned i = 0; i < header.e_phnum; ++i) {
    ElfW(Phdr) part{};
    if (!read_at(header.e_phoff + i * sizeof part, part)) return false;
    if (part.p_offset > size || part.p_filesz > size - part.p_offset) return false;
  }
  return true;
}

}  // namespace

std::string why_untrusted(const fs::path& file) {
  for (fs::path each = file;; each = each.parent_path()) {
    if (auto trouble = why_untrusted_one(each); !trouble.empty() || each == each.root_path()) return trouble;
  }
}

DriverModules::DriverModules(const std::optional<fs::path>& given)
    : folder_(fs::absolute(given ? *given : default_folder())) {}

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
  const fs::path real = fs::canonical(file, error);  // the target of links: it is verified and then loaded
  entry.trouble = error ? file.string() + ": " + error.message() : why_untrusted(real);
  if (!entry.trouble.empty()) return entry;
  try {
    if (!is_whole(open_regular_file(real).get()))
      entry.trouble = file.string() + " is no module, or is cut short: install it anew";
  } catch (const std::system_error& unfit) {
    entry.trouble = unfit.what();
  }
  if (!entry.trouble.empty()) return entry;
  void* library = dlopen(real.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    entry.trouble =
        std::string("it cannot be loaded: ") + dlerror();  // NOLINT(concurrency-mt-unsafe): set-up thread
    return entry;
  }
  using Entry = const DriverModule* (*)();
  const auto symbol = reinterpret_cast<Entry>(dlsym(library, kDriverSymbol));
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
