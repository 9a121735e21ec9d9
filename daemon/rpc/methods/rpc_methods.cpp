#include "daemon/rpc/methods/rpc_methods.hpp"

#include <algorithm>
#include <new>

#include "daemon/board/as_of.hpp"
#include "daemon/can/dbc.hpp"
#include "daemon/rpc/methods/attach_request.hpp"
#include "daemon/rpc/methods/estimate_text.hpp"
#include "daemon/rpc/methods/releasing_request.hpp"
#include "daemon/rpc/methods/status.hpp"
#include "daemon/rpc/protocol/request_params.hpp"
#include "daemon/telemetry/metrics.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

}  // namespace

RpcMethods::RpcMethods(ServiceContext& context, Recorder& recorder)
    : context_(context),
      frames_(context),
      rebias_(context),
      recordings_(context, recorder),
      cached_texts_(context.board.sensors.size()) {
  // Registers a method; one that is not in the table cannot be.
  const auto serve = [this](const char* name, Handler handler) {
    methods_[name] = {&rpc::facts_of(name), std::move(handler)};
  };
  // One that needs no client and responds at once.
  const auto plain = [&](const char* name, auto body) {
    serve(name, [body](Client&, const Params& params, const Reply& reply) { reply.result(body(params)); });
  };
  plain("version", [](const Params&) {
    return json{{"name", "slipd"}, {"version", SLIPD_VERSION}, {"protocol", 1}};
  });
  plain("sensors", [this](const Params&) { return sensors_json(context_); });
  plain("status", [this](const Params&) { return status_json(context_); });
  plain("metrics",
        [this](const Params&) { return json(metrics_text(context_, MetricsFormat::open_metrics)); });
  plain("dbc", [this](const Params&) {
    if (!context_.settings.can)
      throw rpc::Error(rpc::kNotPossible, "there is no CAN output: the configuration has no section can");
    return json(can::dbc_text(*context_.settings.can, can::source_names(context_.settings)));
  });
  serve("gamma", [this](Client&, const Params& params, const Reply& reply) { reply.text(gamma(params)); });
  plain("tradeoff", [this](const Params& params) -> json {
    const SensorStatus& status = *context_.board.sensors[required_sensor(params, context_.board)];
    const DeviceFacts facts = status.facts();
    if (facts.tradeoff.rows.empty()) {
      throw rpc::Error(rpc::kNotPossible,
                       "there is no table of this sensor: its device is not open yet, or single frames of it "
                       "do not tell their margin (few taxels, one force vector, a flat skin)");
    }
    return tradeoff_json(status.name, facts.method, facts.budget_us, facts.tradeoff);
  });
  plain("flight", [this](const Params& params) { return recordings_.flight(params); });
  serve("rebias", [this](Client& client, const Params& params, const Reply& reply) {
    rebias_.add(client, params, reply);
  });
  plain("releasing", [this](const Params& params) { return releasing(params, context_.board); });
  serve("frame", [this](Client& client, const Params& params, const Reply& reply) {
    frames_.add(client, params, reply);
  });
  serve("record", [this](Client& client, const Params& params, const Reply& reply) {
    recordings_.record(client, params, reply);
  });
  serve("attach", [this](Client& client, const Params& params, const Reply& reply) {
    attach_to_board(context_, client, params, reply);
  });
  serve("subscribe", [this](Client& client, const Params& params, const Reply& reply) {
    subscribe(client, params, reply);
  });
  serve("unsubscribe", [this](Client& client, const Params& params, const Reply& reply) {
    unsubscribe(client, params, reply);
  });
  plain("rpc.discover", [](const Params&) { return rpc::open_rpc_document(); });
}

void RpcMethods::line(const std::shared_ptr<Client>& client, std::string_view text) {
  client->expect_response();
  rpc::Line parsed = rpc::parse(text);
  if (!parsed.error_response.empty()) return client->respond(std::move(parsed.error_response));
  const auto answers = std::make_shared<rpc::Responses>(
      parsed.batch, parsed.requests.size(), [client](std::string all) { client->respond(std::move(all)); },
      client->promise(0));
  for (const rpc::Request& request : parsed.requests) {
    if (request.error_response) {
      answers->add(*request.error_response);
    } else if (parsed.batch && client->owed_too_much()) {
      ++refused_;
      Reply(request, answers)
          .error(rpc::kTooMuch, "the answers to this batch are too large; read them, and ask the rest again");
    } else if ((parsed.batch || request.notification) && sent_alone(request.method)) {
      Reply(request, answers)
          .error(rpc::kInvalidRequest, "the answer carries a descriptor: send this request alone");
    } else {
      call(*client, request, Reply(request, answers));
    }
  }
}

// Whether the method must not be part of a batch.
bool RpcMethods::sent_alone(const std::string& name) const {
  const auto method = methods_.find(name);
  return method != methods_.end() && method->second.facts->alone;
}

void RpcMethods::call(Client& client, const rpc::Request& request, const Reply& reply) {
  const auto method = methods_.find(request.method);
  if (method == methods_.end()) {
    return reply.error(rpc::kMethodNotFound, "there is no method \"" + request.method + "\"");
  }
  try {
    refuse_unknown(request.params, *method->second.facts);
    method->second.handler(client, request.params, reply);
  } catch (const rpc::Error& error) {
    reply.error(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    reply.error(rpc::kInternalError, "slipd has not enough memory for this");
  } catch (const std::exception& error) {
    reply.error(rpc::kInternalError, error.what());
  }
}

std::string RpcMethods::gamma(const Params& params) {
  constexpr std::size_t kUsualBytes = 768;
  const Board& board = context_.board;
  const bool all = !params.contains("sensor");
  const std::size_t only = all ? 0 : required_sensor(params, board);
  const Now now = Now::read();
  std::string text;
  text.reserve(kUsualBytes * (all ? board.sensors.size() + board.grasps.size() : 1));
  text += R"({"sensors":[)";
  for (std::size_t i = 0; i < board.sensors.size(); ++i) {
    if (!all && i != only) continue;
    if (text.back() != '[') text += ',';
    const SensorStatus& status = *board.sensors[i];
    const Estimate estimate = as_of(now.monotonic_ns, status).estimate;
    const bool simulated = status.simulated.load(std::memory_order_relaxed);
    if (!cached_texts_[i].is_of(estimate, simulated))
      cached_texts_[i] = EstimateText(estimate, status.name, simulated);
    cached_texts_[i].append_to(text, now);
  }
  text += R"(],"grasps":[)";
  for (std::size_t i = 0; i < board.grasps.size(); ++i) {
    const GraspStatus& grasp = *board.grasps[i];
    if (!all && std::find(grasp.sensors.begin(), grasp.sensors.end(), only) == grasp.sensors.end()) continue;
    if (text.back() != '[') text += ',';
    append_grasp(text, as_of(now.monotonic_ns, board, grasp), grasp.name,
                 context_.settings.grasps[i].sensors);
  }
  text += "]}";
  return text;
}

void RpcMethods::subscribe(Client& client, const Params& params, const Reply& reply) {
  constexpr std::size_t kMostSubscriptions = 16;
  if (client.subscriptions.size() >= kMostSubscriptions) {
    throw rpc::Error(rpc::kInvalidParams, "a client has at most 16 subscriptions; unsubscribe one first");
  }
  const int id = client.subscriptions_made + 1;
  client.subscriptions.emplace_back(id, params, context_.board);
  client.subscriptions_made = id;
  reply.result({{"subscription", id}});
}

void RpcMethods::unsubscribe(Client& client, const Params& params, const Reply& reply) {
  const auto id = params.find("subscription");
  if (id == params.end() || !id->is_number_integer()) {
    throw rpc::Error(rpc::kInvalidParams, "\"subscription\" must be the number that subscribe gave");
  }
  if (std::erase_if(client.subscriptions, [&](const Subscription& each) { return each.id() == *id; }) == 0) {
    throw rpc::Error(rpc::kInvalidParams, "this client has no subscription " + id->dump());
  }
  reply.result(true);
}

void RpcMethods::fail_pending() {
  constexpr const char* kWhy = "slipd has stopped or taken up another configuration; ask again";
  frames_.fail(kWhy);
  rebias_.fail(kWhy);
}

}  // namespace slipd
