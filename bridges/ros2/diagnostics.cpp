#include "bridges/ros2/diagnostics.hpp"

#include <slipd.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace slipd::ros2 {
namespace {

std::string text_of(double value) {
  return nlohmann::json(value).dump();
}

}  // namespace

DiagnosticStatus status_of(const SlipEstimate& last, const std::string& hardware,
                           std::optional<double> rate_hz, std::uint64_t dropped) {
  DiagnosticStatus status;
  const bool fine = last.state == SlipEstimate::kOk || last.state == SlipEstimate::kNoContact;
  status.level.value = fine                                 ? DiagnosticStatus::kOk
                       : last.state == SlipEstimate::kStale ? DiagnosticStatus::kStale
                       : last.state >= SlipEstimate::kFault ? DiagnosticStatus::kError
                                                            : DiagnosticStatus::kWarn;
  status.name = "slipd: " + last.name;
  status.message = slipd_state_name(last.state);
  status.hardware_id = hardware;
  status.values = {{.key = "state", .value = slipd_state_name(last.state)},
                   {.key = "alert", .value = slipd_alert_name(last.alert)},
                   {.key = "rate_hz", .value = rate_hz ? text_of(*rate_hz) : ""},
                   {.key = "age_s", .value = std::isfinite(last.age) ? text_of(last.age) : ""},
                   {.key = "dropped", .value = std::to_string(dropped)},
                   {.key = "simulated", .value = last.simulated ? "true" : "false"}};
  return status;
}

}  // namespace slipd::ros2
