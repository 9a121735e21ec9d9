// Loads the module slipd-paper.so, which contains the trained methods svd-knn and registered, when a scene
// first needs it.
#pragma once

#include "paper/paper_module.hpp"

namespace slipd {

// Called from any set-up thread: io, set-up. Loaded once; a module that could not be used is tried again.
// Throws std::runtime_error, which says what to install, and which methods need nothing.
const PaperModule& paper_module();

}  // namespace slipd
