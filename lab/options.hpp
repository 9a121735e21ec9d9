// Options that several commands have. Each refers to a variable that outlives the command; what it holds
// before is the default.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "paper/validation/trial_frames.hpp"

namespace CLI {
class App;
}

namespace lab {

// "relative" or "sensor": static storage.
const char* name_of(slipd::NoiseKind kind) noexcept;

// --grasps, --threads.
void add_grasps_option(CLI::App& command, std::size_t& grasps, const char* about = "of each line");
void add_threads_option(CLI::App& command, unsigned& threads);

// --sides: taxels along each side of a square pad, in a list. --methods: names of method_choices(), in a
// list.
void add_sides_option(CLI::App& command, std::vector<std::size_t>& sides);
void add_methods_option(CLI::App& command, std::vector<std::string>& methods);

// --presets: names of sim::preset_of, in a list. `allowed`: those that the command knows.
void add_presets_option(CLI::App& command, std::vector<std::string>& presets,
                        const std::vector<std::string>& allowed, const char* about);

// --frame-s: time between two frames, s.
void add_frame_option(CLI::App& command, double& frame_s);

// --noise alone, of sensor noise; or with --noise-kind. fraction: half-width of the uniform noise, 0 … 1.
void add_noise_option(CLI::App& command, double& fraction);
void add_noise_options(CLI::App& command, double& fraction, slipd::NoiseKind& kind);

}  // namespace lab
