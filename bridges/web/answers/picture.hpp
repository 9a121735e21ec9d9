// Frames as pictures for a canvas: a byte for each value, a quarter of what slipd's own numbers take.
// Messages of the WebSocket are bytes: the head's length (uint32, little-endian), the head in JSON, the
// values. Any thread.
//
//   {"kind":"layout","sensor","taxels"}: x and y of each taxel, mm, as float32, little-endian
//   {"kind":"frame","sensor","taxels","seq","age_ms","made_ms","peak_pa","peak_shear_pa"}: of each taxel the
//   pressure as
//     a share of peak_pa in 255ths (uint8; below 0 is 0), then shear x, then y, as shares of peak_shear_pa in
//     127ths (int8)
#pragma once

#include <string>
#include <string_view>

#include "bridges/web/answers/answer.hpp"

namespace slipd::web {

// From slipd's answer to `frame` with encoding bytes; made_ms is Answer::had_ms. Throws std::exception for an
// answer of another form, and for a frame that is older than max_age_ms or of a sensor that is stale: of what
// is past there is no picture.
std::string frame_picture(const std::string& sensor, const Answer& answer, double max_age_ms);

// The places of taxels, from slipd's answer to `frame`. Throws as above.
std::string layout_picture(const std::string& sensor, std::string_view answer);

}  // namespace slipd::web
