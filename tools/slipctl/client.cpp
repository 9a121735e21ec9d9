#include "tools/slipctl/client.hpp"

#include <utility>

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

json RpcClient::call(const std::string& method, const json& params, std::chrono::milliseconds timeout,
                     int passed_fd) {
  const auto until = Clock::now() + timeout;
  try {
    return connection_.answer(connection_.request(method, params.dump(), passed_fd, until), until,
                              [this](json&& message) { keep(std::move(message)); });
  } catch (const Failure& failure) {
    if (failure.code() == SLIPD_REFUSED) throw RpcError(failure.rpc_code(), failure.what());
    if (failure.code() == SLIPD_TIMEOUT)
      throw ClientError("the daemon at " + path_ + " did not answer " + method + " within " +
                        std::to_string(timeout.count()) + " ms");
    throw ClientError(path_ + ": " + failure.what());
  }
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
