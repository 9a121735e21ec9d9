// The work-precision table on the socket. io thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/model/work_precision.hpp"

namespace slipd {

// {"sensor", "chosen", "budget_us", "rows": [{"method", "mean_error", …}]}; unknown numbers are null.
nlohmann::ordered_json tradeoff_json(const std::string& sensor, const std::string& chosen, double budget_us,
                                     const WorkPrecision& work_precision);

}  // namespace slipd
