#include "tests/support/rpc_client.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "core/storage/descriptor_passing.hpp"

namespace slipd::testing {

using nlohmann::json;

RpcClient::RpcClient(const std::filesystem::path& socket_path)
    : fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, socket_path.c_str(), sizeof address.sun_path - 1);
  if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const std::string why = std::strerror(errno);
    close(fd_);
    throw std::runtime_error("connect to " + socket_path.string() + ": " + why);
  }
}

RpcClient::~RpcClient() {
  close(fd_);
}

bool RpcClient::send(const std::string& bytes, int descriptor) {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const auto done =
        send_passing(fd_, std::string_view(bytes).substr(sent), sent == 0 ? descriptor : -1, MSG_NOSIGNAL);
    if (done < 0) return false;
    sent += static_cast<std::size_t>(done);
  }
  return true;
}

void RpcClient::finish() {
  shutdown(fd_, SHUT_WR);
}

std::optional<std::string> RpcClient::line(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  for (;;) {
    if (const auto end = input_.find('\n'); end != std::string::npos) {
      std::string text = input_.substr(0, end);
      input_.erase(0, end + 1);
      return text;
    }
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    pollfd ready{fd_, POLLIN, 0};
    if (ended_ || left.count() < 0 || poll(&ready, 1, static_cast<int>(left.count())) <= 0)
      return std::nullopt;
    std::array<char, 65536> bytes{};
    PassedDescriptors passed;
    const auto got = receive_passed(fd_, bytes, passed, 0);
    if (passed.count > 0) passed_ = std::move(passed.files[passed.count - 1]);
    if (got <= 0) {
      ended_ = true;
    } else {
      input_.append(bytes.data(), static_cast<std::size_t>(got));
    }
  }
}

bool RpcClient::closed_by_peer(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!ended_ && std::chrono::steady_clock::now() < until) line(std::chrono::milliseconds(100));
  return ended_;
}

json RpcClient::call(const std::string& method, const json& params, int descriptor) {
  const int id = ++next_id_;
  send(json{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}}.dump() + "\n",
       descriptor);
  while (const auto text = line()) {
    json message = json::parse(*text);
    if (message.contains("id") && message["id"] == id) return message;
    notifications_.push_back(std::move(message));
  }
  throw NoAnswer("no answer to " + method + (ended_ ? ": the connection is closed" : ""));
}

json RpcClient::result(const std::string& method, const json& params) {
  const json answer = call(method, params);
  if (!answer.contains("result")) throw std::runtime_error(method + ": " + answer.dump());
  return answer["result"];
}

json RpcClient::record(const std::string& sensor, double seconds, const std::filesystem::path& file) {
  const json answer = call("record", {{"sensor", sensor}, {"seconds", seconds}});
  if (!answer.contains("result")) return answer;
  copy_to_end(take_descriptor(), file);
  for (;;) {
    const json heard = notification();
    if (heard["method"] == "recorded") return heard["params"];
  }
}

void copy_to_end(UniqueFd from, const std::filesystem::path& file) {
  if (!from) return;
  std::ofstream out(file, std::ios::binary);
  std::array<char, 65536> bytes{};
  for (;;) {
    pollfd ready{from.get(), POLLIN, 0};
    if (poll(&ready, 1, kPollPatience) <= 0) throw std::runtime_error("nothing comes of the recording");
    const auto got = recv(from.get(), bytes.data(), bytes.size(), 0);
    if (got <= 0) return;
    out.write(bytes.data(), got).flush();
  }
}

json RpcClient::notification() {
  if (notifications_.empty()) {
    const auto text = line();
    if (!text) throw std::runtime_error("no notification came");
    return json::parse(*text);
  }
  json first = std::move(notifications_.front());
  notifications_.pop_front();
  return first;
}

}  // namespace slipd::testing
