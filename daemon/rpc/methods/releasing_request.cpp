#include "daemon/rpc/methods/releasing_request.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/rpc/protocol/request_params.hpp"
#include "daemon/rpc/protocol/rpc.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

double seconds_of(const nlohmann::json& params) {
  const auto given = params.find("seconds");
  if (given == params.end() || !given->is_number() || !(*given >= 0) || !(*given <= kLongestReleaseS))
    throw rpc::Error(rpc::kInvalidParams,
                     "\"seconds\" must be how long the robot lets go, 0 to 60; 0: no longer");
  return given->get<double>();
}

bool sees_displacements(const SensorStatus& status) {
  return status.facts().sensor_class == SensorClass::displacement;
}

}  // namespace

nlohmann::ordered_json releasing(const nlohmann::json& params, Board& board) {
  constexpr double kNsPerSecond = 1e9;
  const bool all = !params.contains("sensor");
  const std::size_t only = all ? 0 : required_sensor(params, board);
  const double for_s = seconds_of(params);
  const std::int64_t now_ns = Now::read().monotonic_ns;
  auto named = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < board.sensors.size(); ++i) {
    SensorStatus& status = *board.sensors[i];
    if ((!all && i != only) || !sees_displacements(status)) continue;
    status.releasing_until_ns.store(now_ns + static_cast<std::int64_t>(for_s * kNsPerSecond),
                                    std::memory_order_relaxed);
    named.push_back(status.name);
  }
  if (named.empty())
    throw rpc::Error(rpc::kNotPossible,
                     (all ? "no sensor here sees" : board.sensors[only]->name + " does not see") +
                         std::string(" displacements, or is not open yet; one that measures forces needs no "
                                     "word of the robot"));
  return {{"sensors", std::move(named)}, {"seconds", for_s}};
}

}  // namespace slipd
