#include "daemon/rpc/rpc_methods.hpp"

#include <unistd.h>

#include <algorithm>
#include <new>
#include <system_error>

#include "daemon/can/dbc.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/rpc/descriptors.hpp"
#include "daemon/rpc/estimate_text.hpp"
#include "daemon/rpc/request_params.hpp"
#include "daemon/rpc/status.hpp"
#include "daemon/telemetry/metrics.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

// Of the text of a frame, as measured on frames of which half the taxels are loaded.
constexpr std::size_t kFrameBytesPerTaxel = 40;
// Of answers that all clients together have requested and not read, beyond which there are no more frames.
constexpr std::size_t kMostOwedToAll = std::size_t{24} * 1024 * 1024;
constexpr double kRecordingsPerSecond = 2;  // started for one sensor, in the long run
constexpr double kRecordingsAtOnce = 20;    // after a pause

json frame_json(const FrameCopy::Content& frame, const TaxelLayout& layout, const Now& now) {
  std::vector<double> x_mm(layout.x_m().begin(), layout.x_m().end());
  std::vector<double> y_mm(layout.y_m().begin(), layout.y_m().end());
  for (auto* axis : {&x_mm, &y_mm}) {
    for (double& value : *axis) value *= 1e3;
  }
  return {{"seq", frame.sequence},
          {"time_ns", now.realtime_of(frame.time_ns)},
          {"normal_pa", frame.normal_pa},
          {"shear_x_pa", frame.shear_x_pa},
          {"shear_y_pa", frame.shear_y_pa},
          {"x_mm", x_mm},
          {"y_mm", y_mm}};
}

// The slots of the shared memory that a client waits for: those of the names in "wait", else all.
std::vector<std::size_t> slots_named(const nlohmann::json& params, const Board& board) {
  const std::size_t sensors = board.sensors.size();
  const auto wait = params.find("wait");
  std::vector<std::size_t> slots;
  if (wait != params.end() && !wait->is_array())
    throw rpc::Error(rpc::kInvalidParams, "\"wait\" must be a list of names of sensors and grasps");
  const auto wanted = [&](const std::string& name) {
    return wait == params.end() || std::find(wait->begin(), wait->end(), name) != wait->end();
  };
  for (std::size_t i = 0; i < sensors; ++i) {
    if (wanted(board.sensors[i]->name)) slots.push_back(i);
  }
  for (std::size_t i = 0; i < board.grasps.size(); ++i) {
    if (wanted(board.grasps[i]->name)) slots.push_back(sensors + i);
  }
  if (wait == params.end()) return slots;
  for (const nlohmann::json& name : *wait) {
    const auto is_it = [&](const auto& each) { return name == each->name; };
    if (std::none_of(board.grasps.begin(), board.grasps.end(), is_it)) sensor_index(name, board);  // throws
  }
  return slots;
}

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

RpcMethods::RpcMethods(ServiceContext& context, Recorder& recorder)
    : context_(context),
      recorder_(recorder),
      cached_texts_(context.board.sensors.size()),
      pending_frames_(context.board.sensors.size()),
      record_rates_(context.board.sensors.size(), RequestRate(kRecordingsPerSecond, kRecordingsAtOnce)) {
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
    return tradeoff_json(status.name, facts.method, context_.settings.estimator.budget_us, facts.tradeoff);
  });
  plain("flight", [this](const Params& params) { return flight(params); });
  const auto with_client = [&](const char* name, auto member) {
    serve(name, [this, member](Client& client, const Params& params, const Reply& reply) {
      (this->*member)(client, params, reply);
    });
  };
  with_client("rebias", &RpcMethods::rebias);
  with_client("frame", &RpcMethods::frame);
  with_client("record", &RpcMethods::record);
  with_client("subscribe", &RpcMethods::subscribe);
  with_client("unsubscribe", &RpcMethods::unsubscribe);
  with_client("attach", &RpcMethods::attach);
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
    const Estimate estimate = status.latest.load().estimate;
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
    append_grasp(text, grasp.latest.load(), grasp.name, context_.settings.grasps[i].sensors);
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

// Once a connection and configuration, so that descriptors under way are limited by the number of clients.
void RpcMethods::attach(Client& client, const Params& params, const Reply& reply) {
  Board& board = context_.board;
  std::vector<std::size_t> slots = slots_named(params, board);
  std::vector<std::string> sensors, grasps;
  for (const auto& sensor : board.sensors) sensors.push_back(sensor->name);
  for (const auto& grasp : board.grasps) grasps.push_back(grasp->name);
  try {
    board.shared.open(sensors, grasps);
    if (client.attachment != nullptr && client.attached_generation == board.shared.generation()) {
      throw rpc::Error(
          rpc::kNotPossible,
          "this connection has attached already; use the descriptor that it got, or connect anew");
    }
    UniqueFd descriptor = out_of_the_way(board.shared.descriptor());
    client.attachment = board.shared.wait_for(slots);
    client.attached_generation = board.shared.generation();
    client.pass_with_response(std::move(descriptor));
  } catch (const std::system_error& error) {
    throw rpc::Error(rpc::kNotPossible, error.what());
  }
  context_.ring_estimate();
  reply.result({{"bytes", board.shared.bytes()},
                {"generation", board.shared.generation()},
                {"sensors", sensors},
                {"grasps", grasps}});
}

void RpcMethods::frame(Client& client, const Params& params, const Reply& reply) {
  const std::size_t sensor = required_sensor(params, context_.board);
  SensorStatus& status = *context_.board.sensors[sensor];
  const auto layout = status.facts().layout;
  if (!layout) throw rpc::Error(rpc::kNotPossible, "no frame of this sensor has come yet");
  if (context_.owed_bytes() > kMostOwedToAll) {
    ++refused_;
    throw rpc::Error(rpc::kTooMuch,
                     "slipd keeps too many answers that its clients do not read; ask again later");
  }
  pending_frames_[sensor].push_back({reply, client.promise(kFrameBytesPerTaxel * layout->size())});
  status.frame_copy.request(layout->size());
  context_.ring_estimate();
}

// Triggers the flight recorder for one sensor or for all.
json RpcMethods::flight(const Params& params) {
  if (context_.flight == nullptr) {
    throw rpc::Error(rpc::kNotPossible,
                     "the flight recorder is off; set recorder.seconds in the configuration");
  }
  const Board& board = context_.board;
  const bool all = !params.contains("sensor");
  const std::size_t only = all ? 0 : required_sensor(params, board);
  json names = json::array();
  json recordings = json::array();
  for (std::size_t i = 0; i < board.sensors.size(); ++i) {
    if (!all && i != only) continue;
    if (const auto number = context_.flight->request(i)) {
      recordings.push_back(*number);
      names.push_back(board.sensors[i]->name);
    }
  }
  if (names.empty())
    throw rpc::Error(rpc::kNotPossible,
                     "too many recordings were requested just now; ask again in some seconds");
  return {{"sensors", std::move(names)},
          {"recordings", std::move(recordings)},
          {"folder", context_.flight->folder().string()},
          {"written_in_s", context_.settings.recorder.seconds}};
}

void RpcMethods::record(Client& client, const Params& params, const Reply& reply) {
  constexpr double kLongest = 24 * 3600;
  UniqueFd file = client.take_fd();
  const std::size_t sensor = required_sensor(params, context_.board);
  const auto seconds = params.find("seconds");
  if (seconds == params.end() || !seconds->is_number() || !(*seconds > 0 && *seconds <= kLongest)) {
    throw rpc::Error(rpc::kInvalidParams, "\"seconds\" must be a number, above 0 and at most 86400");
  }
  if (!file)
    throw rpc::Error(rpc::kInvalidParams, "pass the file to record into along, as a descriptor (SCM_RIGHTS)");
  RequestRate& rate = record_rates_[sensor];
  if (!rate.grant(std::chrono::steady_clock::now())) {
    throw rpc::Error(rpc::kNotPossible, "too many recordings of this sensor were requested; ask again in " +
                                            std::to_string(rate.wait_s()) + " s");
  }
  SensorStatus& status = *context_.board.sensors[sensor];
  const auto answer = [reply, name = status.name,
                       counts = context_.recordings](const RecordingResult& result) {
    ++(result.trouble.empty() ? counts->written : counts->failed);
    if (!result.trouble.empty()) {
      return reply.error(rpc::kInternalError, result.trouble + ", after " + std::to_string(result.frames) +
                                                  " frames; " + std::to_string(result.missed) +
                                                  " more did not fit");
    }
    reply.result({{"sensor", name},
                  {"frames", result.frames},
                  {"missed", result.missed},
                  {"bytes", result.bytes},
                  {"seconds", result.seconds}});
  };
  try {
    recorder_.start(status, std::move(file), seconds->get<double>(), client.peer_closed(), answer);
  } catch (const UnfitFile& unfit) {
    rate.give_back();
    throw rpc::Error(rpc::kInvalidParams, unfit.what());
  } catch (const RecordingRefused& refused) {
    rate.give_back();
    throw rpc::Error(rpc::kNotPossible, refused.what());
  }
}

void RpcMethods::rebias(Client& client, const Params& params, const Reply& reply) {
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
  const std::uint32_t request = status.bias.request(force != params.end() && force->get<bool>());
  pending_rebias_.push_back({reply, sensor, request, std::chrono::steady_clock::now() + kPatience});
}

void RpcMethods::complete_rebias(bool late) {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(pending_rebias_, [&](const PendingRebias& wanted) {
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

void RpcMethods::fail_pending() {
  constexpr const char* kWhy = "slipd has stopped or taken up another configuration; ask again";
  for (auto& waiting : pending_frames_) {
    for (const PendingFrame& wanted : std::exchange(waiting, {})) wanted.reply.error(rpc::kNotPossible, kWhy);
  }
  for (const PendingRebias& wanted : std::exchange(pending_rebias_, {}))
    wanted.reply.error(rpc::kNotPossible, kWhy);
}

std::optional<std::chrono::steady_clock::time_point> RpcMethods::complete_frames() {
  const auto begin = std::chrono::steady_clock::now();
  if (begin < next_frames_) return next_frames_;
  for (std::size_t i = 0; i < pending_frames_.size(); ++i) complete_frames_of(i);
  const auto end = std::chrono::steady_clock::now();
  next_frames_ = end + (end - begin);
  return std::nullopt;
}

// All get the same frame. Its text is made once.
void RpcMethods::complete_frames_of(std::size_t sensor) {
  SensorStatus& status = *context_.board.sensors[sensor];
  const FrameCopy::Content* frame = status.frame_copy.result();
  if (frame == nullptr) return;
  const auto waiting = std::exchange(pending_frames_[sensor], {});
  const auto layout = status.facts().layout;
  const bool usable = frame->has_frame && layout && layout->size() == frame->normal_pa.size();
  std::string text;
  const char* trouble = usable ? nullptr : "no frame of this sensor has come yet";
  try {
    if (usable) text = frame_json(*frame, *layout, Now::read()).dump();
  } catch (const std::bad_alloc&) {
    trouble = "slipd has not enough memory for this";
  }
  status.frame_copy.release();
  for (const PendingFrame& wanted : waiting) {
    if (trouble == nullptr) {
      wanted.reply.text(text);
    } else {
      wanted.reply.error(rpc::kNotPossible, trouble);
    }
  }
}

}  // namespace slipd
