// The broker that this program is at, in a file: what a start after a crash passes over. One thread's own.
//
// What a broker sends can end the program: libmosquitto 2.0.11 aborts at a property that it does not know,
// and takes memory for a packet that was only announced until the service's limit is reached. A start that
// went back to that broker would end the same way, and the next broker would never get the alerts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace slipd::mqtt {

class TriedBroker {
 public:
  // `file`: of this program alone.
  explicit TriedBroker(std::filesystem::path file);
  // An orderly end: no broker is passed over at the next start.
  ~TriedBroker();
  TriedBroker(const TriedBroker&) = delete;
  TriedBroker& operator=(const TriedBroker&) = delete;

  // At which the program ended without meaning to, as it was given to note(); none: it did not.
  const std::optional<std::string>& left_behind() const noexcept { return left_behind_; }

  // `broker` is tried from now on. On a disk that does not take it, a crash is not remembered.
  void note(const std::string& broker);

 private:
  std::filesystem::path file_;
  std::optional<std::string> left_behind_;
  std::string noted_;  // what the file has
};

}  // namespace slipd::mqtt
