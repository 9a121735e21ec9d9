// A program that sends frames to the driver push, message by message, also wrong ones. It uses no client of
// slipd. One thread's own.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "core/storage/descriptor_passing.hpp"
#include "core/storage/unique_fd.hpp"
#include "push_layout/layout.hpp"
#include "tests/support/patience.hpp"

namespace slipd::testing {

class PushWriter {
 public:
  struct Answer {
    push_layout::Answer code{};
    std::string text;
  };

  // Connects; is_connected() is false where nobody listens.
  explicit PushWriter(const std::filesystem::path& path)
      : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    const int large = 1 << 20;
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_SNDBUF, &large, sizeof large);
    if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      socket_ = UniqueFd();
  }

  bool is_connected() const { return static_cast<bool>(socket_); }

  // False: the driver has gone, or (with MSG_DONTWAIT) reads too slowly.
  bool send(const void* bytes, std::size_t size, int flags = 0) {
    return ::send(socket_.get(), bytes, size, flags | MSG_NOSIGNAL) == static_cast<ssize_t>(size);
  }
  bool hello(const push_layout::Hello& hello) { return send(&hello, sizeof hello); }

  static std::vector<char> frame(const std::vector<float>& values, push_layout::FrameHead head) {
    std::vector<char> message(sizeof head + values.size() * sizeof(float));
    if (head.size == 0) head.size = static_cast<std::uint32_t>(message.size());
    std::memcpy(message.data(), &head, sizeof head);
    std::memcpy(message.data() + sizeof head, values.data(), values.size() * sizeof(float));
    return message;
  }
  // The head's size is filled in if it is 0.
  bool push(const std::vector<float>& values, const push_layout::FrameHead& head, int flags = 0) {
    const std::vector<char> message = frame(values, head);
    return send(message.data(), message.size(), flags);
  }

  // What the driver says next; code 0xFFFFFFFF: it has closed the connection, or says nothing.
  Answer answer(int flags = 0) {
    std::vector<char> message(1024);
    PassedDescriptors passed;
    ssize_t size = receive_passed(socket_.get(), message, passed, flags);
    if (size < 0 && errno == ECONNRESET) size = receive_passed(socket_.get(), message, passed, flags);
    if (passed.count > 0) ring_ = std::move(passed.files[0]);
    Answer said{push_layout::Answer{0xFFFF'FFFF}, ""};
    if (size < static_cast<ssize_t>(sizeof said.code)) return said;
    std::memcpy(&said.code, message.data(), sizeof said.code);
    said.text.assign(message.data() + sizeof said.code, static_cast<std::size_t>(size) - sizeof said.code);
    return said;
  }

  // The descriptor that came with an answer; negative: none.
  int ring() const { return ring_.get(); }

 private:
  UniqueFd socket_, ring_;
};

}  // namespace slipd::testing
