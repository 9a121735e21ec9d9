// The recordings that slipd wrote, as the page lists and loads them. Called from the serving thread; waits
// for the disk.
#pragma once

#include <cstdint>
#include <string>

namespace slipd::web {

// {"recordings":[{"file","bytes","written_ms"}…]}, the newest first, at most kMostListed; {"trouble"} if the
// folder cannot be read.
std::string recordings_json(const std::string& folder);

// Recordings that are listed.
inline constexpr std::size_t kMostListed = 500;

// Opens a recording of the folder for reading. `name`: as Route::name. Negative: there is none. A link is not
// followed. The caller closes it.
int open_recording(const std::string& folder, const std::string& name);

}  // namespace slipd::web
