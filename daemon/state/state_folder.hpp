// The folder for what slipd keeps over restarts. Trained models are elsewhere, in a cache.
#pragma once

#include <filesystem>

namespace slipd {

// STATE_DIRECTORY, else XDG_STATE_HOME/slipd, else HOME/.local/state/slipd. Does not create it. Throws
// std::runtime_error if none of the variables is set. Called from any thread.
std::filesystem::path state_folder();

}  // namespace slipd
