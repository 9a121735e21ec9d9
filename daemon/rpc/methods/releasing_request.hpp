// The method `releasing`: a client says that the robot lets go of the object, so that a gel that relaxes for
// that reason raises no alarm. It ends by itself, so that a client that dies silences nothing for long.
// Called from one thread: io.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "daemon/board/board.hpp"

namespace slipd {

// The longest time of one request, s.
inline constexpr double kLongestReleaseS = 60;

// Of the sensor that `params` name, or of all that see displacements: from now on for "seconds", 0 …
// kLongestReleaseS; 0: no longer. Throws rpc::Error: kInvalidParams for seconds outside; kNotPossible if no
// such sensor sees displacements.
nlohmann::ordered_json releasing(const nlohmann::json& params, Board& board);

}  // namespace slipd
