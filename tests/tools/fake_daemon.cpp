#include "tests/tools/fake_daemon.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "core/storage/descriptor_passing.hpp"

namespace slipctl::testing {
namespace {

using nlohmann::json;

// True when `fd` is readable, false when the test is over.
bool readable(int fd, int stop) {
  pollfd wanted[] = {{fd, POLLIN, 0}, {stop, POLLIN, 0}};
  while (::poll(wanted, 2, -1) < 0) continue;
  return wanted[1].revents == 0;
}

bool send_all(int client, std::string_view bytes, slipd::UniqueFd passing) {
  while (!bytes.empty()) {
    const ssize_t count = slipd::send_passing(client, bytes, passing.get(), MSG_NOSIGNAL);
    if (count <= 0) return false;
    passing = {};
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

FakeDaemon::FakeDaemon(Answer answer)
    : answer_(std::move(answer)), folder_(temporary_folder()), path_(folder_ + "/slipd.sock") {
  listening_ = slipd::UniqueFd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  stop_ = slipd::UniqueFd(::eventfd(0, EFD_CLOEXEC));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path_.data(), path_.size());
  if (::bind(listening_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listening_.get(), 8) != 0)
    throw std::runtime_error("the fake daemon cannot listen at " + path_);
  thread_ = std::thread([this] { serve(); });
}

FakeDaemon::~FakeDaemon() {
  ::eventfd_write(stop_.get(), 1);
  thread_.join();
  std::filesystem::remove_all(folder_);
}

void FakeDaemon::serve() {
  while (readable(listening_.get(), stop_.get())) {
    const slipd::UniqueFd client(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (client.get() >= 0) converse(client.get());
  }
}

void FakeDaemon::converse(int client) {
  std::string received;
  while (readable(client, stop_.get())) {
    std::array<char, 4096> bytes;
    const ssize_t count = ::recv(client, bytes.data(), bytes.size(), 0);
    if (count <= 0) return;
    received.append(bytes.data(), static_cast<std::size_t>(count));
    for (std::size_t end = received.find('\n'); end != std::string::npos; end = received.find('\n')) {
      slipd::UniqueFd passing;
      const auto answer = answer_({received.substr(0, end), passing});
      received.erase(0, end + 1);
      if (!answer || !send_all(client, *answer, std::move(passing))) return;
    }
  }
}

std::string result_line(const std::string& line, const json& result) {
  return json{{"jsonrpc", "2.0"}, {"id", json::parse(line)["id"]}, {"result", result}}.dump() + "\n";
}

std::string error_line(const std::string& line, int code, const std::string& message) {
  const json error{{"code", code}, {"message", message}};
  return json{{"jsonrpc", "2.0"}, {"id", json::parse(line)["id"]}, {"error", error}}.dump() + "\n";
}

FakeDaemon::Answer by_method(std::map<std::string, std::function<json(const json& params)>> methods) {
  return [methods = std::move(methods)](const Asked& asked) -> std::optional<std::string> {
    const json request = json::parse(asked.line);
    const auto method = methods.find(request["method"].get<std::string>());
    if (method == methods.end()) return error_line(asked.line, -32601, "no such method");
    return result_line(asked.line, method->second(request["params"]));
  };
}

std::string recording_line(const Asked& asked, const std::string& bytes, const json& trouble) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw std::runtime_error("socketpair");
  asked.passing = slipd::UniqueFd(ends[0]);
  const slipd::UniqueFd writing(ends[1]);
  send_all(writing.get(), bytes, {});
  const json end{{"recording", 7}, {"sensor", "left"}, {"frames", 3}, {"trouble", trouble}};
  return result_line(asked.line, {{"recording", 7}, {"sensor", "left"}}) +
         json{{"jsonrpc", "2.0"}, {"method", "recorded"}, {"params", end}}.dump() + "\n";
}

std::string temporary_folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "slipctl-test-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a folder like " + pattern);
  return pattern;
}

}  // namespace slipctl::testing
