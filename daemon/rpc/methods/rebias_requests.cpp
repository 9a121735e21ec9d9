#include "daemon/rpc/methods/rebias_requests.hpp"

#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "daemon/rpc/methods/status.hpp"
#include "daemon/rpc/protocol/request_params.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

// Refuses other users than root and slipd's own. For methods that change more than the client's connection.
void require_owner(uid_t user, const char* to_do) {
  if (user != 0 && user != geteuid())
    throw rpc::Error(rpc::kNotPermitted, std::string("only root and slipd's own user may ") + to_do);
}

// The response to a complete `rebias` request.
void answer_zero(const SensorStatus& status, const Reply& reply) {
  switch (status.bias.report.load().answer) {
    case BiasResult::moving:
      return reply.error(rpc::kNotPossible,
                         status.name + " does not stand still; let go of it and ask again");
    case BiasResult::in_contact:
      return reply.error(rpc::kNotPossible, status.name +
                                                " looks touched; let go of it and ask again, or, if nothing "
                                                "touches it, ask with \"force\": true");
    case BiasResult::gone:
      return reply.error(rpc::kNotPossible, status.name + " went away meanwhile; ask again when it is back");
    case BiasResult::none:
    case BiasResult::taken:
      break;
  }
  json result = zero_json(status);
  result["sensor"] = status.name;
  reply.result(result);
}

}  // namespace

void RebiasRequests::add(Client& client, const nlohmann::json& params, const Reply& reply) {
  constexpr std::chrono::seconds kPatience{30};  // 128 frames at 5 Hz
  const std::size_t sensor = required_sensor(params, context_.board);
  const auto force = params.find("force");
  if (force != params.end() && !force->is_boolean())
    throw rpc::Error(rpc::kInvalidParams, "\"force\" must be true or false");
  require_owner(client.peer().uid, "take a bias anew");
  SensorStatus& status = *context_.board.sensors[sensor];
  if (status.link.load(std::memory_order_acquire) != DeviceLink::open) {
    throw rpc::Error(rpc::kNotPossible, status.name + " sends no frames: its device is not open");
  }
  if (!status.bias.needed.load(std::memory_order_relaxed)) {
    throw rpc::Error(rpc::kNotPossible,
                     status.name + " has no bias that slipd could take anew: its frames come zeroed");
  }
  if (!status.bias.possible.load(std::memory_order_relaxed)) {
    throw rpc::Error(rpc::kNotPossible,
                     status.name + " sends values of an unknown scale: give its driver their scale first");
  }
  const std::uint32_t request = status.bias.request(force != params.end() && force->get<bool>());
  pending_.push_back({reply, sensor, request, std::chrono::steady_clock::now() + kPatience});
}

void RebiasRequests::complete(bool late) {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(pending_, [&](const Pending& wanted) {
    const SensorStatus& status = *context_.board.sensors[wanted.sensor];
    if (status.bias.completed() >= wanted.request) {
      answer_zero(status, wanted.reply);
      return true;
    }
    if (!late || now < wanted.deadline) return false;
    wanted.reply.error(rpc::kNotPossible, status.name + " sends too few frames to take a bias from");
    return true;
  });
}

void RebiasRequests::fail(const char* why) {
  for (const Pending& wanted : std::exchange(pending_, {})) wanted.reply.error(rpc::kNotPossible, why);
}

}  // namespace slipd
