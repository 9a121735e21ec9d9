#include "tests/bench/redis.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <system_error>

#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/load.hpp"

namespace slipd::bench {
namespace {

constexpr const char* kServer = "/usr/bin/redis-server";

std::string ask_once(int fd, const std::string& request) {
  std::array<char, 4096> answer{};
  ssize_t got = -1;
  if (send(fd, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size()))
    got = recv(fd, answer.data(), answer.size(), 0);
  if (got <= 0) throw std::runtime_error("redis-server does not answer");
  return {answer.data(), static_cast<std::size_t>(got)};
}

}  // namespace

std::unique_ptr<Redis> Redis::start() {
  if (std::filesystem::exists(kServer)) return std::unique_ptr<Redis>(new Redis);
  say("refused", {{"peer", "Redis"},
                  {"why", "redis-server is not installed"},
                  {"remedy", "install redis-server (tools/setup --bench does)"}});
  return nullptr;
}

void Redis::set(const std::string& value) const {
  const int fd = connect_to(socket());
  ask_once(fd, "*3\r\n$3\r\nSET\r\n$1\r\nk\r\n$" + std::to_string(value.size()) + "\r\n" + value + "\r\n");
  close(fd);
}

Redis::Redis()
    : program_(folder_, "redis",
               {kServer, "--port", "0", "--unixsocket", socket().string(), "--save", "", "--appendonly", "no",
                "--dir", folder_.path().string()}) {
  for (;;) {
    try {
      const int fd = connect_to(socket());
      ask_once(fd, kRedisGet);
      close(fd);
      return;
    } catch (const std::system_error&) {
      if (program_.wait(std::chrono::milliseconds(1)))
        throw std::runtime_error("redis-server has ended: " + program_.errors());
    }
  }
}

}  // namespace slipd::bench
