// sliplab: computations without a sensor and without the daemon. Exit 0 success, 1 failure, 2 wrong usage.
#include "tools/sliplab/command.hpp"

namespace {

void add_commands(CLI::App& app, const offline::Common& common) {
  sliplab::add_contact(app, common);
  sliplab::add_train(app, common);
  sliplab::add_picture(app, common);
  sliplab::add_replay(app, common);
  sliplab::add_skin(app, common);
  offline::add_merge(app);
}

}  // namespace

// An exception before the command line is read ends the program.
int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return offline::run_program(argc, argv, "sliplab", "Contacts, models and recordings, offline.",
                              add_commands);
}
