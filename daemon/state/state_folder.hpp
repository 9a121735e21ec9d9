// Where slipd keeps what outlives it, but for trained models, which are only a cache.
#pragma once

#include <filesystem>

namespace slipd {

// STATE_DIRECTORY, else slipd below XDG_STATE_HOME, else .local/state/slipd below HOME; not made yet. Throws
// std::runtime_error if none of these is set.
std::filesystem::path state_folder();

}  // namespace slipd
