#include "clients/c/connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>

#include "clients/c/slipd.h"

namespace slipd::client {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{64} * 1024;

[[noreturn]] void disconnected(const std::string& path, int error) {
  std::string what = std::generic_category().message(error);
  if (error == EACCES || error == EPERM)
    what = "not permitted: become a member of the group slipd, and log in again";
  if (error == ENOENT || error == ECONNREFUSED)
    what = "slipd does not run here: start it, or give the path of its socket";
  if (error == EAGAIN) what = "slipd accepts no connections now; try again";
  throw Failure(SLIPD_DISCONNECTED, path + ": " + what);
}

[[noreturn]] void gone() {
  throw Failure(SLIPD_DISCONNECTED, "slipd has closed the connection: it was stopped or restarted");
}

}  // namespace

void Connection::connect(const std::string& path) {
  if (connected()) return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) throw Failure(SLIPD_INVALID, path + ": too long for a socket");
  path.copy(address.sun_path, path.size());
  UniqueFd made(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made) disconnected(path, errno);
  if (::connect(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    disconnected(path, errno);
  close();
  socket_ = std::move(made);
}

void Connection::close() noexcept {
  socket_ = {};
  passed_ = {};
  input_.clear();
  begin_ = 0;
}

// False: it is not ready in time.
bool Connection::wait_for(short events, Clock::time_point until) const {
  pollfd ready{socket_.get(), events, 0};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    const int got = poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
    if (got >= 0) return got > 0;
    if (errno != EINTR) throw Failure(SLIPD_DISCONNECTED, std::generic_category().message(errno));
  }
}

std::uint64_t Connection::request(std::string_view method, std::string_view params, int descriptor,
                                  Clock::time_point until) {
  const std::uint64_t id = ++last_id_;
  std::string text = R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":")";
  text.append(method).append(R"(","params":)").append(params).append("}\n");
  iovec piece{text.data(), text.size()};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  if (descriptor >= 0) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const item = CMSG_FIRSTHDR(&message);
    item->cmsg_level = SOL_SOCKET;
    item->cmsg_type = SCM_RIGHTS;
    item->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(item), &descriptor, sizeof descriptor);
  }
  while (piece.iov_len > 0) {
    const auto sent = sendmsg(socket_.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EAGAIN) {
      if (!wait_for(POLLOUT, until)) throw Failure(SLIPD_TIMEOUT, "slipd does not read in time");
    } else if (sent < 0 && errno != EINTR) {
      gone();
    } else if (sent > 0) {
      piece.iov_base = static_cast<char*>(piece.iov_base) + sent;
      piece.iov_len -= static_cast<std::size_t>(sent);
      message.msg_control = nullptr;  // the descriptor went with the first byte
      message.msg_controllen = 0;
    }
  }
  return id;
}

// False: nothing came in time.
bool Connection::receive(Clock::time_point until) {
  input_.erase(0, begin_);
  begin_ = 0;
  const std::size_t had = input_.size();
  input_.resize(had + kPieceBytes);
  iovec piece{input_.data() + had, kPieceBytes};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  auto got = recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  const int error = errno;
  input_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(0, got)));
  if (got < 0 && (error == EAGAIN || error == EINTR)) {
    return Clock::now() < until && wait_for(POLLIN, until);
  }
  if (got <= 0) gone();
  for (cmsghdr* item = CMSG_FIRSTHDR(&message); item != nullptr; item = CMSG_NXTHDR(&message, item)) {
    if (item->cmsg_level != SOL_SOCKET || item->cmsg_type != SCM_RIGHTS) continue;
    int number = -1;
    std::memcpy(&number, CMSG_DATA(item), sizeof number);
    passed_ = UniqueFd(number);
  }
  return true;
}

bool Connection::line(std::string_view& text, Clock::time_point until) {
  for (;;) {
    const std::size_t end = input_.find('\n', begin_);
    if (end != std::string::npos) {
      text = std::string_view(input_).substr(begin_, end - begin_);
      begin_ = end + 1;
      return true;
    }
    if (!receive(until)) return false;
  }
}

std::string Connection::answer(std::uint64_t id, Clock::time_point until) {
  std::string_view text;
  while (line(text, until)) {
    const nlohmann::json message = nlohmann::json::parse(text, nullptr, false);
    if (!message.is_object()) continue;
    const nlohmann::json& its_id = message.value("id", nlohmann::json());
    if (const auto error = message.find("error"); error != message.end()) {
      if (its_id != id && !its_id.is_null()) continue;
      throw Failure(its_id.is_null() ? SLIPD_DISCONNECTED : SLIPD_REFUSED,
                    error->value("message", "slipd refuses this"));
    }
    if (its_id == id && message.contains("result")) return message["result"].dump();
  }
  throw Failure(SLIPD_TIMEOUT, "slipd does not answer in time");
}

}  // namespace slipd::client
