// Finding what a request speaks of, and refusing what it should not. io thread. Both throw rpc::Error.
#pragma once

#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "daemon/board/board.hpp"

namespace slipd {

// The sensor's index on the board. `name`: any JSON value. Unknown: -32001 with the names that there are; no
// string: -32602.
std::size_t sensor_index(const nlohmann::json& name, const Board& board);

// The sensor that `params` must name in its member "sensor"; absent: -32602.
std::size_t required_sensor(const nlohmann::json& params, const Board& board);

// -32602 for a member that none of `known` is.
void refuse_unknown(const nlohmann::json& params, std::span<const std::string_view> known);
inline void refuse_unknown(const nlohmann::json& params, std::initializer_list<std::string_view> known) {
  refuse_unknown(params, std::span(known.begin(), known.size()));
}

}  // namespace slipd
