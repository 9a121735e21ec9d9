// Where the flight recorder keeps its files: written aside and renamed, so that a file with a recording's
// name is a whole one; at most so many of them, the oldest go, and what a crash left half written goes, too.
// Flight recorder's thread.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <system_error>

namespace slipd {

// STATE_DIRECTORY/recordings, else below XDG_STATE_HOME, else below HOME. Throws std::runtime_error if none
// is set.
std::filesystem::path recordings_directory();

class RecordingsFolder {
 public:
  RecordingsFolder(std::filesystem::path path, std::size_t keep) : path_(std::move(path)), keep_(keep) {}

  // Makes PATH/NAME of what `write` puts into the descriptor it gets, and removes the oldest ones that are
  // then too many. On an error nothing of NAME is left, and what was there stays.
  std::error_code add(const std::string& name, const std::function<std::error_code(int fd)>& write) const;

  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void date_after_the_others(int fd) const;
  void remove_oldest() const;
  std::filesystem::path path_;
  std::size_t keep_;
};

}  // namespace slipd
