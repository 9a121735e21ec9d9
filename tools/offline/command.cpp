#include "tools/offline/command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

namespace offline {

int run_program(int argc, char** argv, const char* name, const char* description,
                void (*add)(CLI::App& app, const Common& common)) {
  Common common;
  CLI::App app{description, name};
  app.set_version_flag("--version", std::string(name) + " " SLIPD_VERSION);
  app.add_option("--out", common.out, "folder for the files that a command writes");
  app.add_flag("--json", common.json, "print the result as one JSON object");
  app.add_option("--seed", common.seed, "seed of all random numbers")->capture_default_str();
  app.require_subcommand(1);
  app.fallthrough();
  add(app, common);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return app.exit(wrong) == 0 ? 0 : 2;
  } catch (const WrongUse& wrong) {
    std::cerr << name << ": " << wrong.what() << '\n';
    return 2;
  } catch (const std::exception& failed) {
    std::cout.flush();
    std::cerr << name << ": " << failed.what() << '\n';
    return 1;
  }
  std::cout.flush();
  if (!std::cout) {
    std::cerr << name << ": the result could not be written to standard output\n";
    return 1;
  }
  return 0;
}

}  // namespace offline
