#include "tools/slipctl/client.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;

// Longest answer, bytes. A frame of a million taxels fits; more is an error of the other end.
constexpr std::size_t kLongestLine = std::size_t{64} << 20;

std::string reason(int error) {
  return std::generic_category().message(error);
}

std::string why_not_connected(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
      return "no daemon at " + path +
             ": nothing is there; start it (systemctl start slipd, or slipd --config FILE), or " +
             "say where its socket is with --socket PATH";
    case ECONNREFUSED:
      return "no daemon at " + path +
             ": a socket file is there, but nobody listens; slipd has stopped or is just " +
             "starting (systemctl status slipd)";
    case EACCES:
    case EPERM:
      return "permission denied at " + path +
             ": its users are in the group slipd; join it (sudo usermod -aG slipd " +
             "$USER, then log in again) or use sudo";
    default:
      return "cannot connect to " + path + ": " + reason(error);
  }
}

UniqueFd connect_to(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path)
    throw ClientError("the socket's path " + path + " must have 1 to " +
                      std::to_string(sizeof address.sun_path - 1) +
                      " bytes; give a shorter one with --socket PATH");
  std::memcpy(address.sun_path, path.data(), path.size());
  UniqueFd fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) throw ClientError("cannot make a socket: " + reason(errno));
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw ClientError(why_not_connected(path, errno));
  return fd;
}

}  // namespace

RpcClient::RpcClient(const std::string& socket_path) : path_(socket_path), socket_(connect_to(socket_path)) {}

json RpcClient::call(const std::string& method, json params, std::chrono::milliseconds timeout,
                     int passed_fd) {
  const std::int64_t id = ++last_id_;
  const json request{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", std::move(params)}};
  send_line(request.dump() + "\n", passed_fd);
  const auto deadline = Clock::now() + timeout;
  while (auto message = receive(deadline)) {
    if (message->contains("method")) {
      keep_notification(*message);
      continue;
    }
    // An answer without an id belongs to a request that could not be parsed; only this one is pending.
    const auto answered = message->find("id");
    if (answered != message->end() && !answered->is_null() && *answered != id) continue;
    if (const auto error = message->find("error"); error != message->end() && error->is_object())
      throw RpcError(error->value("code", 0), error->value("message", "the daemon refused " + method));
    if (!message->contains("result"))
      throw ClientError("the daemon's answer to " + method + " has neither result nor error; is " + path_ +
                        " slipd's?");
    return std::move((*message)["result"]);
  }
  throw ClientError("the daemon at " + path_ + " did not answer " + method + " within " +
                    std::to_string(timeout.count()) + " ms");
}

std::optional<Notification> RpcClient::next(std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  while (waiting_.empty()) {
    auto message = receive(deadline);
    if (!message) return std::nullopt;
    if (message->contains("method")) keep_notification(*message);
  }
  Notification first = std::move(waiting_.front());
  waiting_.pop_front();
  return first;
}

void RpcClient::send_line(const std::string& line, int passed_fd) const {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  std::size_t sent = 0;
  while (sent < line.size()) {
    iovec part{const_cast<char*>(line.data()) + sent, line.size() - sent};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (passed_fd >= 0 && sent == 0) {
      message.msg_control = control.data();
      message.msg_controllen = control.size();
      cmsghdr* header = CMSG_FIRSTHDR(&message);
      header->cmsg_level = SOL_SOCKET;
      header->cmsg_type = SCM_RIGHTS;
      header->cmsg_len = CMSG_LEN(sizeof(int));
      std::memcpy(CMSG_DATA(header), &passed_fd, sizeof passed_fd);
    }
    const ssize_t count = ::sendmsg(socket_.get(), &message, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw ClientError("the daemon at " + path_ + " has gone: " + reason(errno));
    sent += static_cast<std::size_t>(count);
  }
}

std::optional<json> RpcClient::receive(Clock::time_point deadline) {
  while (true) {
    if (const auto line = take_line()) {
      json message = json::parse(*line, nullptr, false);
      if (!message.is_object())
        throw ClientError("what answers at " + path_ + " does not speak JSON-RPC: " + line->substr(0, 60));
      return message;
    }
    if (!wait_readable(deadline)) return std::nullopt;
    read_some();
  }
}

std::optional<std::string> RpcClient::take_line() {
  const std::size_t end = received_.find('\n', searched_);
  if (end == std::string::npos) {
    searched_ = received_.size();
    return std::nullopt;
  }
  std::string line = received_.substr(0, end);
  received_.erase(0, end + 1);
  searched_ = 0;
  return line;
}

bool RpcClient::wait_readable(Clock::time_point deadline) const {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd wanted{socket_.get(), POLLIN, 0};
    const int ready = ::poll(&wanted, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
    if (ready > 0) return true;
    if (ready == 0) return false;
    if (errno != EINTR) throw ClientError("cannot wait for the daemon at " + path_ + ": " + reason(errno));
  }
}

void RpcClient::read_some() {
  std::array<char, 65536> chunk;
  const ssize_t count = ::recv(socket_.get(), chunk.data(), chunk.size(), 0);
  if (count == 0) throw ClientError("the daemon at " + path_ + " closed the connection");
  if (count < 0 && errno != EINTR)
    throw ClientError("the daemon at " + path_ + " has gone: " + reason(errno));
  if (count > 0) received_.append(chunk.data(), static_cast<std::size_t>(count));
  if (received_.size() > kLongestLine)
    throw ClientError("the daemon at " + path_ + " sends a line without end");
}

void RpcClient::keep_notification(json& message) {
  if (!message["method"].is_string()) return;
  waiting_.push_back({message["method"].get<std::string>(), message.value("params", json::object())});
}

}  // namespace slipctl
