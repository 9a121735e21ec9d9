// The folder of the flight recorder's files. A file is written under a temporary name and renamed, so that
// every
// *.rec is complete. The number of files is limited; the oldest are removed. Temporary files that a crash
// left are removed too.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <system_error>

namespace slipd {

// The folder `recordings` of the state folder. Throws as state_folder does. Called from any thread.
std::filesystem::path recordings_directory();

// Not thread-safe. Called from one thread: the flight recorder's.
class RecordingsFolder {
 public:
  // `keep`: files at most, at least 1. Does not create the folder.
  RecordingsFolder(std::filesystem::path path, std::size_t keep) : path_(std::move(path)), keep_(keep) {}

  // Creates PATH/NAME with what `write` writes into the descriptor, then removes the oldest files beyond the
  // limit. On an error PATH/NAME is as it was before.
  std::error_code add(const std::string& name, const std::function<std::error_code(int fd)>& write) const;

  // The folder.
  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void date_after_the_others(int fd) const;
  void remove_oldest() const;
  std::filesystem::path path_;
  std::size_t keep_;
};

}  // namespace slipd
