#include "daemon/rpc/recording_requests.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "daemon/record/flight_recorder.hpp"
#include "daemon/rpc/request_params.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

constexpr double kRecordingsPerSecond = 2;  // started for one sensor, in the long run
constexpr double kRecordingsAtOnce = 20;    // after a pause

}  // namespace

RecordingRequests::RecordingRequests(ServiceContext& context, Recorder& recorder)
    : context_(context),
      recorder_(recorder),
      rates_(context.board.sensors.size(), RequestRate(kRecordingsPerSecond, kRecordingsAtOnce)) {}

void RecordingRequests::record(Client& client, const nlohmann::json& params, const Reply& reply) {
  constexpr double kLongest = 24 * 3600;
  UniqueFd file = client.take_fd();
  const std::size_t sensor = required_sensor(params, context_.board);
  const auto seconds = params.find("seconds");
  if (seconds == params.end() || !seconds->is_number() || !(*seconds > 0 && *seconds <= kLongest)) {
    throw rpc::Error(rpc::kInvalidParams, "\"seconds\" must be a number, above 0 and at most 86400");
  }
  if (!file)
    throw rpc::Error(rpc::kInvalidParams, "pass the file to record into along, as a descriptor (SCM_RIGHTS)");
  RequestRate& rate = rates_[sensor];
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

json RecordingRequests::flight(const nlohmann::json& params) {
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

}  // namespace slipd
