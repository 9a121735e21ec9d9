#include "daemon/rpc/methods/recording_requests.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "daemon/record/flight_recorder.hpp"
#include "daemon/rpc/clients/descriptors.hpp"
#include "daemon/rpc/protocol/request_params.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

constexpr double kRecordingsPerSecond = 2;   // started for one sensor, in the long run
constexpr double kRecordingsAtOnce = 20;     // after a pause
constexpr std::size_t kRecordedBytes = 512;  // of the notification, about

// The ends of a connection on which nothing can be sent back, descriptors neither.
struct Ends {
  UniqueFd reading, writing;
};

Ends make_ends() {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw RecordingRefused("no socket for it: " + std::generic_category().message(errno));
  Ends made{UniqueFd(ends[0]), UniqueFd(ends[1])};
  shutdown(made.writing.get(), SHUT_RD);
  return {out_of_the_way(std::move(made.reading)), out_of_the_way(std::move(made.writing))};
}

// The notification.
std::string recorded(std::uint64_t number, const std::string& sensor, const RecordingResult& result) {
  const json params{{"recording", number},
                    {"sensor", sensor},
                    {"frames", result.frames},
                    {"missed", result.missed},
                    {"bytes", result.bytes},
                    {"seconds", result.seconds},
                    {"trouble", result.trouble.empty() ? json(nullptr) : json(result.trouble)}};
  return json{{"jsonrpc", "2.0"}, {"method", "recorded"}, {"params", params}}.dump();
}

}  // namespace

RecordingRequests::RecordingRequests(ServiceContext& context, Recorder& recorder)
    : context_(context),
      recorder_(recorder),
      rates_(context.board.sensors.size(), RequestRate(kRecordingsPerSecond, kRecordingsAtOnce)) {}

void RecordingRequests::record(Client& client, const nlohmann::json& params, const Reply& reply) {
  constexpr double kLongest = 24 * 3600;
  const std::size_t sensor = required_sensor(params, context_.board);
  const auto seconds = params.find("seconds");
  if (seconds == params.end() || !seconds->is_number() || !(*seconds > 0 && *seconds <= kLongest)) {
    throw rpc::Error(rpc::kInvalidParams, "\"seconds\" must be a number, above 0 and at most 86400");
  }
  RequestRate& rate = rates_[sensor];
  if (!rate.grant(std::chrono::steady_clock::now())) {
    throw rpc::Error(rpc::kNotPossible, "too many recordings of this sensor were requested; ask again in " +
                                            std::to_string(rate.wait_s()) + " s");
  }
  SensorStatus& status = *context_.board.sensors[sensor];
  const auto done = [to = client.weak_from_this(), name = status.name, counts = context_.recordings,
                     owed = std::make_shared<OwedPart>(client.promise(kRecordedBytes))](
                        std::uint64_t number, const RecordingResult& result) {
    ++(result.trouble.empty() || result.left ? counts->written : counts->failed);
    *owed = {};  // from here on the client counts it
    const auto asking = to.lock();
    if (!asking) return;
    try {
      asking->announce(recorded(number, name, result));
    } catch (const std::bad_alloc&) {  // so that the client knows
      asking->close();
    }
  };
  try {
    Ends ends = make_ends();
    const std::uint64_t number =
        recorder_.start(status, std::move(ends.writing), seconds->get<double>(), client.peer_closed(), done);
    client.pass_with_response(std::move(ends.reading));
    reply.result({{"recording", number}, {"sensor", status.name}});
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
