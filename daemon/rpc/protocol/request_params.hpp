// Checks the parameters of requests. Called from one thread: io. All functions throw rpc::Error.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "daemon/board/board.hpp"
#include "daemon/rpc/protocol/method_table.hpp"

namespace slipd {

// The index of a sensor on the board. `name`: any JSON value. kUnknownSensor, with all names, if there is no
// such sensor; kInvalidParams if it is not a string.
std::size_t sensor_index(const nlohmann::json& name, const Board& board);

// The sensor named by the member "sensor" of `params`; kInvalidParams if there is no such member.
std::size_t required_sensor(const nlohmann::json& params, const Board& board);

// kInvalidParams if `params` has a member that the method's facts do not have.
void refuse_unknown(const nlohmann::json& params, const rpc::MethodFacts& method);

}  // namespace slipd
