// The JSON-RPC methods. A method responds at once, or keeps its Reply until the result is there.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/record/recorder.hpp"
#include "daemon/rpc/client.hpp"
#include "daemon/rpc/estimate_text.hpp"
#include "daemon/rpc/rpc.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class RpcMethods {
 public:
  // `context` and `recorder` outlive it.
  RpcMethods(ServiceContext& context, Recorder& recorder);

  // Handles one line of a client; responses go through Client::respond.
  void line(const std::shared_ptr<Client>& client, std::string_view text);

  // Responds to pending `frame` requests whose copies are there.
  void complete_frames();

  // Responds to pending `rebias` requests that are complete and, if `late`, to those whose deadline has
  // passed.
  void complete_rebias(bool late);

  // Responds to all pending requests with an error.
  void fail_pending();

 private:
  using Params = nlohmann::json;
  using Method = std::function<void(Client&, const Params&, const rpc::Reply&)>;

  void call(Client& client, const rpc::Request& request, const rpc::Reply& reply);
  std::string gamma(const Params& params);
  void subscribe(Client& client, const Params& params, const rpc::Reply& reply);
  void unsubscribe(Client& client, const Params& params, const rpc::Reply& reply);
  void frame(const Params& params, const rpc::Reply& reply);
  void rebias(const Client& client, const Params& params, const rpc::Reply& reply);
  nlohmann::ordered_json flight(const Params& params);
  void record(Client& client, const Params& params, const rpc::Reply& reply);

  ServiceContext& context_;
  Recorder& recorder_;
  std::map<std::string, Method, std::less<>> methods_;
  struct PendingRebias {
    rpc::Reply reply;
    std::size_t sensor = 0;
    std::uint32_t request = 0;
    std::chrono::steady_clock::time_point deadline;
  };
  std::vector<EstimateText> cached_texts_;               // per sensor, of method gamma
  std::vector<std::vector<rpc::Reply>> pending_frames_;  // per sensor
  std::vector<PendingRebias> pending_rebias_;
};

}  // namespace slipd
