// slipd-lab: measures slipd itself, on simulated contacts and sensors. For developers; in no package. Exit 0
// success, 1 failure, 2 wrong usage.
#include "lab/command.hpp"

namespace {

void add_commands(CLI::App& app, const offline::Common& common) {
  lab::add_tradeoff(app, common);
  lab::add_torque(app, common);
  lab::add_histories(app, common);
  lab::add_faults(app, common);
  lab::add_gels(app, common);
  lab::add_coverage(app, common);
  lab::add_overload(app, common);
  lab::add_alerts(app, common);
  lab::add_paper(app, common);
  lab::add_stability(app, common);
  lab::add_method_table(app, common);
#ifdef SLIPD_MUJOCO
  lab::add_grip(app, common);
#endif
  offline::add_merge(app);
}

}  // namespace

// An exception before the command line is read ends the program.
int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return offline::run_program(argc, argv, "slipd-lab",
                              "How accurate slipd is, how fast, and what it survives.", add_commands);
}
