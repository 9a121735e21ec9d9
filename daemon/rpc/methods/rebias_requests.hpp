// The method `rebias`: the acquire thread measures a sensor's zero, and the client that asked is answered
// when it is there. Called from one thread: io.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "daemon/rpc/clients/client.hpp"
#include "daemon/rpc/protocol/rpc.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

class RebiasRequests {
 public:
  // `context` outlives it.
  explicit RebiasRequests(ServiceContext& context) : context_(context) {}

  // Begins one. Throws rpc::Error.
  void add(Client& client, const nlohmann::json& params, const rpc::Reply& reply);
  // Responds to those that are complete and, if `late`, to those whose deadline has passed.
  void complete(bool late);
  // Responds to all with an error.
  void fail(const char* why);

 private:
  struct Pending {
    rpc::Reply reply;
    std::size_t sensor = 0;
    std::uint32_t request = 0;
    std::chrono::steady_clock::time_point deadline;
  };
  ServiceContext& context_;
  std::vector<Pending> pending_;
};

}  // namespace slipd
