#include "daemon/record/recordings_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <vector>

#include "core/storage/unique_fd.hpp"
#include "daemon/state/state_folder.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;

// A temporary file that is older has no writer any more and is removed. Shorter than the longest write: a
// file in use is removed.
constexpr auto kLongestWrite = std::chrono::minutes(10);

std::error_code last_error() {
  return {errno, std::generic_category()};
}

}  // namespace

fs::path recordings_directory() {
  return state_folder() / "recordings";
}

std::error_code RecordingsFolder::add(const std::string& name, const std::string& kind,
                                      const std::function<std::error_code(int fd)>& write) const {
  std::error_code error;
  // Independent of the umask: slipd's group may read it.
  if (fs::create_directories(path_, error)) chmod(path_.c_str(), 0750);
  if (error) return error;
  const fs::path file = path_ / file_name(name, kind);
  const fs::path aside = file.string() + ".part";
  fs::remove(aside, error);  // left by a killed process; a link there must not be followed
  UniqueFd opened(open(aside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0640));
  if (!opened) return last_error();
  fchmod(opened.get(), 0640);  // as above
  error = write(opened.get());
  if (!error) date_after_the_others(opened.get());
  if (!error && fdatasync(opened.get()) != 0) error = last_error();
  if (!error) fs::rename(aside, file, error);
  std::error_code ignored;
  if (error) fs::remove(aside, ignored);
  if (!error) remove_oldest(kind);
  return error;
}

// The oldest files are found by their time. So the last written must have the newest, even if the clock was
// set back.
void RecordingsFolder::date_after_the_others(int fd) const {
  struct stat mine {};
  if (fstat(fd, &mine) != 0) return;
  const auto later = [](const timespec& a, const timespec& b) {
    return a.tv_sec != b.tv_sec ? a.tv_sec > b.tv_sec : a.tv_nsec > b.tv_nsec;
  };
  std::error_code ignored;
  timespec newest{};
  for (const auto& item : fs::directory_iterator(path_, ignored)) {
    struct stat other {};
    if (item.path().extension() == ".rec" && stat(item.path().c_str(), &other) == 0 &&
        later(other.st_mtim, newest))
      newest = other.st_mtim;
  }
  if (later(mine.st_mtim, newest)) return;
  constexpr long kStepNs = 1'000'000, kSecondNs = 1'000'000'000;
  newest.tv_nsec += kStepNs;
  newest.tv_sec += newest.tv_nsec / kSecondNs;
  newest.tv_nsec %= kSecondNs;
  const timespec both[2] = {newest, newest};
  futimens(fd, both);
}

void RecordingsFolder::remove_oldest(const std::string& kind) const {
  const std::string ending = file_name("", kind);
  std::error_code ignored;
  std::vector<std::pair<fs::file_time_type, fs::path>> found;
  const auto long_ago = fs::file_time_type::clock::now() - kLongestWrite;
  for (const auto& item : fs::directory_iterator(path_, ignored)) {
    if (item.symlink_status(ignored).type() != fs::file_type::regular) continue;
    const auto written = item.last_write_time(ignored);
    if (item.path().filename().string().ends_with(ending)) found.emplace_back(written, item.path());
    if (item.path().extension() == ".part" && written < long_ago) fs::remove(item.path(), ignored);
  }
  std::sort(found.begin(), found.end());
  for (std::size_t i = 0; i + keep_ < found.size(); ++i) fs::remove(found[i].second, ignored);
}

}  // namespace slipd
