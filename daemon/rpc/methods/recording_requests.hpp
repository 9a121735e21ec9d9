// The methods `record` and `flight`: recordings that clients ask for. Called from one thread: io.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "daemon/record/recorder.hpp"
#include "daemon/record/request_rate.hpp"
#include "daemon/rpc/clients/client.hpp"
#include "daemon/rpc/protocol/rpc.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

class RecordingRequests {
 public:
  // `context` and `recorder` outlive it.
  RecordingRequests(ServiceContext& context, Recorder& recorder);

  // Responds with a descriptor that the client reads the recording from, and tells it the end by the
  // notification `recorded`. Throws rpc::Error.
  void record(Client& client, const nlohmann::json& params, const rpc::Reply& reply);
  // Triggers the flight recorder for one sensor or for all. Throws rpc::Error.
  nlohmann::ordered_json flight(const nlohmann::json& params);

 private:
  ServiceContext& context_;
  Recorder& recorder_;
  std::vector<RequestRate> rates_;  // per sensor
};

}  // namespace slipd
