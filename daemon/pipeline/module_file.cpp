#include "daemon/pipeline/module_file.hpp"

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <system_error>

#include "core/storage/regular_file.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;

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

fs::path default_module_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  fs::path beside = program.parent_path().parent_path() / "drivers";
  if (!error && fs::is_directory(beside, error)) return beside;
  return SLIPD_INSTALLED_MODULES;
}

std::string why_untrusted(const fs::path& file) {
  for (fs::path each = file;; each = each.parent_path()) {
    if (auto trouble = why_untrusted_one(each); !trouble.empty() || each == each.root_path()) return trouble;
  }
}

ModuleFile load_module_file(const fs::path& file) {
  ModuleFile out;
  std::error_code error;
  const fs::path real = fs::canonical(file, error);  // the target of links: it is verified and then loaded
  out.trouble = error ? file.string() + ": " + error.message() : why_untrusted(real);
  if (!out.trouble.empty()) return out;
  try {
    if (!is_whole(open_regular_file(real).get()))
      out.trouble = file.string() + " is no module, or is cut short: install it anew";
  } catch (const std::system_error& unfit) {
    out.trouble = unfit.what();
  }
  if (!out.trouble.empty()) return out;
  out.library = dlopen(real.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (out.library == nullptr)
    out.trouble =
        std::string("it cannot be loaded: ") + dlerror();  // NOLINT(concurrency-mt-unsafe): own thread's
  return out;
}

}  // namespace slipd
