#include "tools/slipctl/client.hpp"

#include <utility>

#include "clients/c/recording.hpp"
#include "clients/c/slipd.h"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;
using slipd::client::Clock;
using slipd::client::Failure;

}  // namespace

RpcClient::RpcClient(const std::string& socket_path) : path_(socket_path) {
  try {
    connection_.connect(path_);
  } catch (const Failure& failure) {
    throw ClientError(std::string(failure.what()) + "; slipctl looks elsewhere with --socket PATH");
  }
}

template <typename Body>
json RpcClient::asking(const std::string& what, Body body) {
  try {
    return body([this](json&& message) { keep(std::move(message)); });
  } catch (const Failure& failure) {
    if (failure.code() == SLIPD_REFUSED) throw RpcError(failure.rpc_code(), failure.what());
    if (failure.code() == SLIPD_INVALID) throw ClientError(failure.what());
    if (failure.code() == SLIPD_TIMEOUT)
      throw ClientError("the daemon at " + path_ + " did not answer " + what);
    throw ClientError(path_ + ": " + failure.what());
  }
}

json RpcClient::call(const std::string& method, const json& params, std::chrono::milliseconds timeout) {
  const auto until = Clock::now() + timeout;
  return asking(method + " within " + std::to_string(timeout.count()) + " ms", [&](const auto& keep_others) {
    return connection_.answer(connection_.request(method, params.dump(), until), until, keep_others);
  });
}

json RpcClient::record(const std::string& sensor, double seconds, int file) {
  constexpr auto kPatience = std::chrono::seconds(10);
  return asking("record in time", [&](const auto& keep_others) {
    return slipd::client::record(connection_, json(sensor).dump(), seconds, file, kPatience, keep_others);
  });
}

std::optional<Notification> RpcClient::next(std::chrono::milliseconds timeout) {
  const auto until = Clock::now() + timeout;
  try {
    json message;
    while (waiting_.empty()) {
      if (!connection_.message(message, until)) return std::nullopt;
      keep(std::move(message));
    }
  } catch (const Failure& failure) {
    throw ClientError(path_ + ": " + failure.what());
  }
  Notification first = std::move(waiting_.front());
  waiting_.pop_front();
  return first;
}

// Messages that are no notifications are answers to requests that were given up.
void RpcClient::keep(json&& message) {
  const auto method = message.find("method");
  if (method == message.end() || !method->is_string()) return;
  waiting_.push_back({method->get<std::string>(), message.value("params", json::object())});
}

}  // namespace slipctl
