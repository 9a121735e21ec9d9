// The commands of sliplab. Each has its own file and adds itself to the command line.
#pragma once

#include "tools/offline/command.hpp"

namespace sliplab {

// Each adds its subcommand, which runs while the command line is parsed and throws when it fails.
void add_contact(CLI::App& app, const offline::Common& common);
void add_train(CLI::App& app, const offline::Common& common);
void add_replay(CLI::App& app, const offline::Common& common);
void add_skin(CLI::App& app, const offline::Common& common);
void add_picture(CLI::App& app, const offline::Common& common);

}  // namespace sliplab
