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
#include "daemon/rpc/clients/client.hpp"
#include "daemon/rpc/methods/estimate_text.hpp"
#include "daemon/rpc/methods/frame_requests.hpp"
#include "daemon/rpc/methods/rebias_requests.hpp"
#include "daemon/rpc/methods/recording_requests.hpp"
#include "daemon/rpc/protocol/method_table.hpp"
#include "daemon/rpc/protocol/rpc.hpp"
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
  std::optional<std::chrono::steady_clock::time_point> complete_frames() { return frames_.complete(); }

  // Requests that were refused because the answers to others are too large, or are not read.
  std::uint64_t refused() const noexcept { return refused_ + frames_.refused(); }

  // Responds to pending `rebias` requests that are complete and, if `late`, to those whose deadline has
  // passed.
  void complete_rebias(bool late) { rebias_.complete(late); }

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

  ServiceContext& context_;
  FrameRequests frames_;
  RebiasRequests rebias_;
  RecordingRequests recordings_;
  std::map<std::string, Method, std::less<>> methods_;
  std::vector<EstimateText> cached_texts_;  // per sensor, of method gamma
  std::uint64_t refused_ = 0;               // of batches
};

}  // namespace slipd
