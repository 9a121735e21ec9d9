// The commands of slipd-lab. Each has its own file and adds itself to the command line.
#pragma once

#include "tools/offline/command.hpp"

namespace lab {

// Each adds its subcommand, which runs while the command line is parsed and throws when it fails.
void add_tradeoff(CLI::App& app, const offline::Common& common);
void add_stability(CLI::App& app, const offline::Common& common);
void add_torque(CLI::App& app, const offline::Common& common);
void add_histories(CLI::App& app, const offline::Common& common);
void add_coverage(CLI::App& app, const offline::Common& common);
void add_paper(CLI::App& app, const offline::Common& common);
void add_faults(CLI::App& app, const offline::Common& common);
void add_gels(CLI::App& app, const offline::Common& common);
void add_alerts(CLI::App& app, const offline::Common& common);
void add_overload(CLI::App& app, const offline::Common& common);
void add_method_table(CLI::App& app, const offline::Common& common);
// Where MuJoCo was there when slipd was built.
void add_grip(CLI::App& app, const offline::Common& common);

}  // namespace lab
