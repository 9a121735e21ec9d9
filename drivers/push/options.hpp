// The options of driver `push`, parsed from JSON that fits options.json. Set-up.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "driver_api/driver.hpp"
#include "push_layout/layout.hpp"

namespace slipd::push {

struct Options {
  std::optional<push_layout::Unit> unit;  // none: as the writer says
  std::optional<std::uint8_t> axes;       // 1 or 3; none: as the writer says
  std::optional<bool> zeroed;             // none: as the writer says
  // Factors of x, y and z; Pa per unit of the frames, of N times the taxel's area. None: 1.
  std::optional<std::array<float, 3>> scale;
  std::int64_t max_age_ns = 0;  // of a sample when its frame arrives
  std::filesystem::path path;   // of the socket
  unsigned mode = 0660;         // of the socket
  std::string owner, group;     // of the socket; empty: slipd's own
};

// Throws DriverError for a layout whose frames no message can hold, and for a path that is too long.
Options parse_options(const SensorSetup& sensor);

}  // namespace slipd::push
