// The socket of a service manager, which programs under test tell their state (sd_notify(3)).
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string_view>

#include "core/storage/unique_fd.hpp"

namespace slipd::testing {

class NotifySocket {
 public:
  // `path` is for the program's NOTIFY_SOCKET.
  explicit NotifySocket(const std::filesystem::path& path)
      : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("bind");
  }

  // Takes the next message, which comes within `patience`. Whether `text` is in it.
  bool says(std::string_view text, std::chrono::milliseconds patience) const {
    std::array<char, 512> bytes{};
    const auto got = next(bytes, patience);
    return got > 0 && std::string_view(bytes.data(), static_cast<std::size_t>(got)).find(text) != text.npos;
  }

  // Takes all messages that have come.
  void forget() const {
    std::array<char, 512> bytes{};
    while (next(bytes, std::chrono::milliseconds(0)) > 0) {
    }
  }

 private:
  ssize_t next(std::array<char, 512>& bytes, std::chrono::milliseconds patience) const {
    pollfd ready{socket_.get(), POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(patience.count())) <= 0) return 0;
    return recv(socket_.get(), bytes.data(), bytes.size(), 0);
  }
  UniqueFd socket_;
};

}  // namespace slipd::testing
