#include "bridges/modbus/server.hpp"

#include <arpa/inet.h>
#include <modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "bridges/support/log.hpp"

namespace slipd::modbus {
namespace {

using Clock = std::chrono::steady_clock;

// A frame of Modbus TCP: transaction and protocol (2 bytes each), length of what follows (2), unit, function,
// data.
constexpr std::size_t kHeaderBytes = 6, kMostBytes = MODBUS_TCP_MAX_ADU_LENGTH;
constexpr std::size_t kFunctionAt = 7, kReadRequestBytes = 12;
constexpr std::chrono::seconds kLookPeriod{1};
constexpr double kMillisecondsPerSecond = 1e3;

[[noreturn]] void fail(const ServerSettings& settings, int error) {
  throw std::runtime_error(settings.address + ":" + std::to_string(settings.port) +
                           ": cannot listen: " + std::generic_category().message(error));
}

}  // namespace

struct Server::Client {
  int fd;
  std::array<std::uint8_t, kMostBytes> input{};
  std::size_t bytes = 0;  // in input
  Clock::time_point last_request = Clock::now();
  bridges::Loop::Watch watch;

  explicit Client(int socket) : fd(socket) {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() {
    watch = {};
    close(fd);
  }
};

void Server::Free::operator()(modbus_t* context) const noexcept {
  modbus_free(context);
}
void Server::Free::operator()(modbus_mapping_t* mapping) const noexcept {
  modbus_mapping_free(mapping);
}

ServerSettings server_settings_of(const nlohmann::json& checked) {
  ServerSettings settings;
  settings.address = checked.at("address");
  settings.port = checked.at("port");
  if (checked.contains("blocks")) settings.blocks = checked["blocks"].get<std::vector<std::string>>();
  settings.max_age_s = checked.at("max_age_ms").get<double>() / kMillisecondsPerSecond;
  settings.max_clients = checked.at("max_clients");
  settings.idle = std::chrono::milliseconds(
      static_cast<std::int64_t>(kMillisecondsPerSecond * checked.at("idle_s").get<double>()));
  settings.socket = checked.at("socket");
  return settings;
}

Server::Server(ServerSettings settings, bridges::Loop& loop)
    : settings_(std::move(settings)),
      loop_(loop),
      context_(modbus_new_tcp(nullptr, settings_.port)),
      mapping_(modbus_mapping_new(0, 0, 0, kRegisters)),
      timer_(loop, [this] { look_around(); }),
      registers_(loop, settings_.socket, settings_.blocks, settings_.max_age_s) {
  if (!context_ || !mapping_) throw std::bad_alloc();
  // libmodbus sleeps this long before some exceptions.
  modbus_set_response_timeout(context_.get(), 0, 1);
  listen_at();
  timer_.start(kLookPeriod);
  bridges::log(bridges::LogLevel::notice, "answers PLCs on " + settings_.address + ":" +
                                              std::to_string(settings_.port) + "; asks slipd on " +
                                              settings_.socket);
}

Server::~Server() {
  listen_watch_ = {};
  if (listening_ >= 0) close(listening_);
}

void Server::listen_at() {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(settings_.port));
  if (inet_pton(AF_INET, settings_.address.c_str(), &at.sin_addr) != 1) fail(settings_, EINVAL);
  listening_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  if (listening_ < 0 || setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      bind(listening_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
      listen(listening_, SOMAXCONN) != 0)
    fail(settings_, errno);
  listen_watch_ =
      bridges::Loop::Watch(loop_, listening_, EPOLLIN, [this](std::uint32_t) { accept_client(); });
}

void Server::accept_client() {
  const int fd = accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) return;
  if (clients_.size() >= settings_.max_clients) {
    close(fd);
    return;
  }
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  Client& client = clients_.emplace_back(fd);
  client.watch = bridges::Loop::Watch(loop_, fd, EPOLLIN, [this, &client](std::uint32_t) {
    if (!serve(client)) drop(&client);
  });
}

// One read and the answers to what is whole. False: the connection has ended, or does not speak Modbus.
bool Server::serve(Client& client) {
  const auto got = recv(client.fd, client.input.data() + client.bytes, client.input.size() - client.bytes, 0);
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  if (got == 0) return false;
  client.bytes += static_cast<std::size_t>(got);
  while (client.bytes >= kHeaderBytes) {
    const auto& in = client.input;
    const std::size_t length = kHeaderBytes + (std::size_t{in[4]} << 8U) + in[5];
    if (in[2] != 0 || in[3] != 0 || length <= kFunctionAt || length > kMostBytes) return false;
    if (client.bytes < length) return true;
    if (!answer(client, length)) return false;
    client.bytes -= length;
    std::memmove(client.input.data(), client.input.data() + length, client.bytes);
  }
  return true;
}

// A client that does not take its answer is dropped: the socket does not wait.
bool Server::answer(Client& client, std::size_t length) {
  client.last_request = Clock::now();
  modbus_set_socket(context_.get(), client.fd);
  const std::uint8_t* const request = client.input.data();
  if (request[kFunctionAt] != MODBUS_FC_READ_INPUT_REGISTERS)
    return modbus_reply_exception(context_.get(), request, MODBUS_EXCEPTION_ILLEGAL_FUNCTION) >= 0;
  if (length != kReadRequestBytes)
    return modbus_reply_exception(context_.get(), request, MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE) >= 0;
  registers_.write({mapping_->tab_input_registers, std::size_t{kRegisters}});
  return modbus_reply(context_.get(), request, static_cast<int>(length), mapping_.get()) >= 0;
}

void Server::drop(Client* client) {
  clients_.remove_if([&](const Client& each) { return &each == client; });
}

// Also without requests slipd is looked for, so that the log tells of it.
void Server::look_around() {
  timer_.start(kLookPeriod);
  const auto begin = Clock::now() - settings_.idle;
  clients_.remove_if([&](const Client& each) { return each.last_request < begin; });
  registers_.alive();
}

}  // namespace slipd::modbus
