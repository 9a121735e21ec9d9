#include "bridges/web/answers/recordings.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace slipd::web {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kEnding = ".rec";

struct Listed {
  std::string file;
  std::int64_t bytes, written_ms;
};

// Absent: it is no regular file.
bool look_at(const fs::path& path, Listed& out) {
  struct stat facts {};
  if (lstat(path.c_str(), &facts) != 0 || !S_ISREG(facts.st_mode)) return false;
  constexpr std::int64_t kMsPerS = 1000, kNsPerMs = 1'000'000;
  out = {path.filename().string(), facts.st_size,
         kMsPerS * facts.st_mtim.tv_sec + facts.st_mtim.tv_nsec / kNsPerMs};
  return true;
}

}  // namespace

std::string recordings_json(const std::string& folder) {
  if (folder.empty())
    return R"({"trouble":"slipd-web has no folder of recordings (setting \"recordings\")."})";
  std::error_code error;
  std::vector<Listed> found;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    Listed one;
    if (at->path().extension() == kEnding && look_at(at->path(), one)) found.push_back(std::move(one));
  }
  if (error && error != std::errc::no_such_file_or_directory)
    return nlohmann::json{{"trouble", folder + ": " + error.message()}}.dump(
        -1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::sort(found.begin(), found.end(), [](const Listed& a, const Listed& b) {
    return a.written_ms != b.written_ms ? a.written_ms > b.written_ms : a.file < b.file;
  });
  if (found.size() > kMostListed) found.resize(kMostListed);
  nlohmann::json list = nlohmann::json::array();
  for (const Listed& one : found)
    list.push_back({{"file", one.file}, {"bytes", one.bytes}, {"written_ms", one.written_ms}});
  return nlohmann::json{{"recordings", std::move(list)}}.dump(-1, ' ', true,
                                                              nlohmann::json::error_handler_t::replace);
}

int open_recording(const std::string& folder, const std::string& name) {
  if (folder.empty() || !name.ends_with(kEnding) || name.find('/') != name.npos) return -1;
  const int folder_fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_fd < 0) return -1;
  const int fd = openat(folder_fd, name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  close(folder_fd);
  struct stat facts {};
  if (fd >= 0 && (fstat(fd, &facts) != 0 || !S_ISREG(facts.st_mode))) {
    close(fd);
    return -1;
  }
  return fd;
}

}  // namespace slipd::web
