// The JSON-RPC methods. A method responds at once, or keeps its Reply until the result is there.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/record/recorder.hpp"
#include "daemon/record/request_rate.hpp"
#include "daemon/rpc/client.hpp"
#include "daemon/rpc/estimate_text.hpp"
#include "daemon/rpc/method_table.hpp"
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

  // Responds to pending `frame` requests whose copies are there, unless the time for such answers is used up:
  // they get at most half of the thread's. Then it returns when to call it again.
  std::optional<std::chrono::steady_clock::time_point> complete_frames();

  // Requests of batches that were refused because the answers to the others were too large already.
  std::uint64_t refused() const noexcept { return refused_; }

  // Responds to pending `rebias` requests that are complete and, if `late`, to those whose deadline has
  // passed.
  void complete_rebias(bool late);

  // Responds to all pending requests with an error.
  void fail_pending();

 private:
  using Params = nlohmann::json;
  using Handler = std::function<void(Client&, const Params&, const rpc::Reply&)>;
  struct Method {
    const rpc::MethodFacts* facts = nullptr;
    Handler handler;
  };

  void call(Client& client, const rpc::Request& request, const rpc::Reply& reply);
  bool sent_alone(const std::string& name) const;
  std::string gamma(const Params& params);
  void subscribe(Client& client, const Params& params, const rpc::Reply& reply);
  void unsubscribe(Client& client, const Params& params, const rpc::Reply& reply);
  void attach(Client& client, const Params& params, const rpc::Reply& reply);
  void frame(Client& client, const Params& params, const rpc::Reply& reply);
  void complete_frames_of(std::size_t sensor);
  void rebias(Client& client, const Params& params, const rpc::Reply& reply);
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
  std::vector<EstimateText> cached_texts_;  // per sensor, of method gamma
  struct PendingFrame {
    rpc::Reply reply;
    OwedPart promised;
  };
  std::vector<std::vector<PendingFrame>> pending_frames_;  // per sensor
  std::chrono::steady_clock::time_point next_frames_{};    // no frame is answered before
  std::vector<RequestRate> record_rates_;                  // per sensor
  std::uint64_t refused_ = 0;
  std::vector<PendingRebias> pending_rebias_;
};

}  // namespace slipd
