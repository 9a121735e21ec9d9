// sliplab: computations without a sensor and without the daemon. Exit 0 success, 1 failure, 2 wrong usage.
#include <CLI/CLI.hpp>
#include <iostream>

#include "tools/sliplab/command.hpp"

// An exception before the command line is read ends the program.
int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  using namespace sliplab;
  Common common;
  CLI::App app{"Contacts, models and accuracy, offline.", "sliplab"};
  app.set_version_flag("--version", "sliplab " SLIPD_VERSION);
  app.add_option("--out", common.out, "folder for the files that a command writes");
  app.add_flag("--json", common.json, "print the result as one JSON object");
  app.add_option("--seed", common.seed, "seed of all random numbers")->capture_default_str();
  app.require_subcommand(1);
  app.fallthrough();
  add_contact(app, common);
  add_train(app, common);
  add_tradeoff(app, common);
  add_torque(app, common);
  add_histories(app, common);
  add_faults(app, common);
  add_coverage(app, common);
  add_overload(app, common);
  add_alerts(app, common);
  add_paper(app, common);
  add_picture(app, common);
  add_replay(app, common);
  add_skin(app, common);
  add_stability(app, common);
  add_merge(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return app.exit(wrong) == 0 ? 0 : 2;
  } catch (const WrongUse& wrong) {
    std::cerr << "sliplab: " << wrong.what() << '\n';
    return 2;
  } catch (const std::exception& failed) {
    std::cout.flush();
    std::cerr << "sliplab: " << failed.what() << '\n';
    return 1;
  }
  std::cout.flush();
  if (!std::cout) {
    std::cerr << "sliplab: the result could not be written to standard output\n";
    return 1;
  }
  return 0;
}
