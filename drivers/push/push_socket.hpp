// The socket that writers connect to, and its file. Set-up thread; `get` any.
#pragma once

#include <sys/types.h>
#include <sys/un.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "core/storage/unique_fd.hpp"

namespace slipd::push {

// A socket has its path with this behind it until it listens. The longest path of a Unix socket has room for
// it.
inline constexpr char kUnready[] = "~";
inline constexpr std::size_t kLongestPath = sizeof sockaddr_un{}.sun_path - sizeof kUnready;

class PushSocket {
 public:
  // Listens nowhere.
  PushSocket() = default;
  // Makes the folder of the path if it is missing, replaces a socket that nobody listens on, and listens.
  // `owner`, `group`: empty: the process's own. Throws DriverError.
  PushSocket(std::filesystem::path path, unsigned mode, const std::string& owner, const std::string& group);
  // Removes the file, unless another program has replaced it.
  ~PushSocket();
  PushSocket(PushSocket&& other) noexcept = default;
  PushSocket& operator=(PushSocket&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(listener_, other.listener_);
    std::swap(made_, other.made_);
    return *this;
  }

  // The listening descriptor, which never blocks; negative: none.
  int get() const noexcept { return listener_.get(); }

 private:
  void listen_at(unsigned mode, const std::string& owner, const std::string& group);

  std::filesystem::path path_;
  UniqueFd listener_;
  std::optional<std::pair<dev_t, ino_t>> made_;  // the file, as it was made
};

}  // namespace slipd::push
