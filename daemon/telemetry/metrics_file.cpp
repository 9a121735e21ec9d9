#include "daemon/telemetry/metrics_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/storage/regular_file.hpp"
#include "core/storage/unique_fd.hpp"
#include "daemon/log/log.hpp"
#include "daemon/rt/environment.hpp"
#include "daemon/state/state_folder.hpp"
#include "daemon/telemetry/metrics.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".prom";
constexpr std::string_view kFirstWords = "# TYPE slipd_";  // of every file that slipd makes
constexpr const char* kRuntimeFolder = "/run/slipd";

std::string message_of(int error) {
  return std::generic_category().message(error);
}

bool begins_as_slipds(const fs::path& file) {
  std::string text(kFirstWords.size(), '\0');
  try {
    const UniqueFd opened = open_regular_file(file);
    if (read(opened.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) return false;
  } catch (const std::system_error&) {
    return false;
  }
  return text == kFirstWords;
}

std::string why_not_replaced(const fs::path& file) {
  struct stat there {};
  if (lstat(file.c_str(), &there) != 0) return {};
  const bool own = there.st_uid == geteuid() || geteuid() == 0;
  if (S_ISREG(there.st_mode) && there.st_nlink == 1 && own && begins_as_slipds(file)) return {};
  return "is there already, and slipd did not make it; remove it, or choose another name";
}

bool is_in_group(gid_t group) {
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(0, getgroups(0, nullptr))));
  const int count = getgroups(static_cast<int>(groups.size()), groups.data());
  groups.resize(static_cast<std::size_t>(std::max(0, count)));
  groups.push_back(getegid());
  return std::find(groups.begin(), groups.end(), group) != groups.end();
}

// slipd's own folders, as far as there are any.
std::vector<fs::path> own_folders() {
  std::vector<fs::path> own{kRuntimeFolder};
  if (const auto runtime = environment_variable("RUNTIME_DIRECTORY"); !runtime.empty())
    own.emplace_back(runtime);
  try {
    own.push_back(state_folder());
  } catch (const std::runtime_error&) {  // there is none
  }
  return own;
}

bool is_below(const fs::path& inner, const fs::path& outer) {
  const auto [rest, ignored] = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
  return rest == outer.end();
}

std::string why_folder_refused(const fs::path& folder) {
  std::error_code error;
  const fs::path real = fs::canonical(folder, error);
  if (error) return {};  // writing fails, and says why
  for (const fs::path& own : own_folders()) {
    if (is_below(real, fs::weakly_canonical(own, error))) return {};
  }
  struct stat status {};
  if (stat(real.c_str(), &status) != 0) return {};
  const bool opened_to_group =
      (status.st_mode & S_IWGRP) != 0 && (status.st_mode & S_IWOTH) == 0 && is_in_group(status.st_gid);
  if (geteuid() == 0 || status.st_uid == geteuid() || opened_to_group) return {};
  return "lies in " + real.string() +
         ", which is not slipd's: choose /run/slipd, or open the folder to slipd with chgrp slipd and chmod "
         "g+w";
}

}  // namespace

std::string why_no_metrics_file(const fs::path& file) {
  const std::string name = file.filename().string();
  if (!name.ends_with(kEnding) || name == kEnding) return "expected a name that ends in .prom";
  std::string why = why_not_replaced(file);
  return why.empty() ? why_folder_refused(file.parent_path()) : why;
}

MetricsFile::~MetricsFile() {
  struct stat there {};
  if (written_ && lstat(settings_.file.c_str(), &there) == 0 &&
      written_ == std::pair(there.st_dev, there.st_ino))
    unlink(settings_.file.c_str());
}

// Why it failed; empty: it did not.
std::string MetricsFile::replace(const std::string& text) {
  if (std::string why = why_no_metrics_file(settings_.file); !why.empty()) return why;
  fs::path aside = settings_.file;
  aside += ".new-" + std::to_string(getpid());
  unlink(aside.c_str());  // left by an earlier process of the same id
  const auto failed = [&](int error) {
    unlink(aside.c_str());
    return "cannot be written: " + message_of(error) + "; the service may write below " + kRuntimeFolder;
  };
  const UniqueFd fd(open(aside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!fd) return failed(errno);
  fchmod(fd.get(), 0644);  // independent of the umask
  const auto size = write(fd.get(), text.data(), text.size());
  if (size != static_cast<ssize_t>(text.size())) return failed(size < 0 ? errno : ENOSPC);
  struct stat made {};
  if (fstat(fd.get(), &made) != 0 || rename(aside.c_str(), settings_.file.c_str()) != 0) return failed(errno);
  written_ = std::pair(made.st_dev, made.st_ino);
  return {};
}

void MetricsFile::write_if_due(const ServiceContext& context, std::chrono::steady_clock::time_point now) {
  if (settings_.file.empty() || now < due_) return;
  due_ = now + settings_.period;
  const std::string why = replace(metrics_text(context, MetricsFormat::prometheus));
  if (!why.empty() && !refused_) {
    write_log(LogLevel::warning, {{}, Cause::configuration},
              "metrics.file: " + settings_.file.string() + " " + why);
  }
  refused_ = !why.empty();
}

}  // namespace slipd
