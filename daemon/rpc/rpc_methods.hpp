// The methods on the socket, by name. A method answers at once, or keeps its Reply until what it waits for
// has come. io thread.
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

class RpcMethods {
 public:
  RpcMethods(ServiceContext& context, Recorder& recorder);

  // Answers one line of a client, through Client::answer.
  void line(const std::shared_ptr<Client>& client, std::string_view text);

  // The estimate thread may have left frames that were asked for: answers those who wait for them.
  void answer_frames();

  // The keeper of zeros may have settled what was asked for: answers those who wait for it, and, `late`,
  // those who have waited too long.
  void answer_rebias(bool late);

  void give_up_waiting();  // nothing of it will come

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
  struct Rebias {
    rpc::Reply reply;
    std::size_t sensor = 0;
    std::uint32_t request = 0;
    std::chrono::steady_clock::time_point given_up;
  };
  std::vector<EstimateText> said_;                      // per sensor, by gamma
  std::vector<std::vector<rpc::Reply>> frames_wanted_;  // per sensor
  std::vector<Rebias> rebias_wanted_;
};

}  // namespace slipd
