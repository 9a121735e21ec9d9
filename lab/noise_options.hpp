// The noise of simulated frames on the command line.
#pragma once

#include "paper/validation/trial_frames.hpp"

namespace CLI {
class App;
}

namespace lab {

// "relative" or "sensor": static storage.
const char* name_of(slipd::NoiseKind kind) noexcept;

// Adds --noise and --noise-kind. fraction: half-width of the uniform noise, 0 … 1. What both refer to before
// is the default; both outlive the command.
void add_noise_options(CLI::App& command, double& fraction, slipd::NoiseKind& kind);

}  // namespace lab
