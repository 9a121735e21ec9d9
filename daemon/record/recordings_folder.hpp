// The folder of the flight recorder's files. A file is written under a temporary name and renamed, so that
// every *.rec is complete. The number of files of each kind is limited; the oldest of the kind are removed,
// so that recordings that clients request cost none of a slip. Temporary files that a crash left are removed
// too.
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
  // `keep`: files of each kind at most, at least 1. Does not create the folder.
  RecordingsFolder(std::filesystem::path path, std::size_t keep) : path_(std::move(path)), keep_(keep) {}

  // The name of a file of this kind: NAME-KIND.rec.
  static std::string file_name(const std::string& name, const std::string& kind) {
    return name + "-" + kind + ".rec";
  }

  // Creates PATH/NAME-KIND.rec with what `write` writes into the descriptor, then removes the oldest files of
  // the kind beyond the limit. On an error that file is as it was before.
  std::error_code add(const std::string& name, const std::string& kind,
                      const std::function<std::error_code(int fd)>& write) const;

  // The folder.
  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void date_after_the_others(int fd) const;
  void remove_oldest(const std::string& kind) const;
  std::filesystem::path path_;
  std::size_t keep_;
};

}  // namespace slipd
