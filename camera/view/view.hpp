// What slipd-camera sees, as a picture for setting it up: dots that are followed, dots that are lost, and the
// displacement at the nodes. Any one thread.
#pragma once

#include <span>
#include <string>

#include "camera/frames/gel_reader.hpp"

namespace slipd::camera {

// Writes `path`, a name that ends with .png or .jpg, of what `reader` has read last: `values`. Throws
// std::runtime_error.
void write_view(const std::string& path, const GelReader& reader, std::span<const float> values);

}  // namespace slipd::camera
