// A recording that slipd makes for its client: asked for, copied into the client's own file, and its account.
// One thread's own. libslipd and slipctl are built on it.
#pragma once

#include <functional>
#include <string_view>

#include "clients/c/connection.hpp"

namespace slipd::client {

// Records a sensor for `seconds` into `file`, which the caller opened for writing, and returns the parameters
// of the notification `recorded`. `patience`: how much longer than `seconds` it may take. `sensor`: JSON
// text. Other messages go to `other`, or are thrown away. Throws Failure: SLIPD_INVALID, with the system's
// reason, if `file` takes nothing. What was copied before can be read.
Json record(Connection& connection, std::string_view sensor, double seconds, int file,
            Clock::duration patience, const std::function<void(Json&&)>& other = {});

}  // namespace slipd::client
