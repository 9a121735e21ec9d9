// The options that all commands of sliplab share. Each command has its own file and adds itself to the
// command line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>

namespace CLI {
class App;
}

namespace sliplab {

struct Common {
  std::filesystem::path out;  // --out: folder for files; empty: none are written
  bool json = false;          // --json: results as one JSON object
  std::uint64_t seed = 1;     // --seed: of all random numbers
};

// Invalid input: ends the program with 2, as an invalid option does.
class WrongUse : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Each adds its subcommand, which runs while the command line is parsed and throws when it fails.
void add_contact(CLI::App& app, const Common& common);
void add_train(CLI::App& app, const Common& common);
void add_tradeoff(CLI::App& app, const Common& common);
void add_stability(CLI::App& app, const Common& common);
void add_torque(CLI::App& app, const Common& common);
void add_histories(CLI::App& app, const Common& common);
void add_coverage(CLI::App& app, const Common& common);
void add_paper(CLI::App& app, const Common& common);
void add_faults(CLI::App& app, const Common& common);
void add_alerts(CLI::App& app, const Common& common);
void add_overload(CLI::App& app, const Common& common);
void add_replay(CLI::App& app, const Common& common);
void add_skin(CLI::App& app, const Common& common);
void add_merge(CLI::App& app);
void add_picture(CLI::App& app, const Common& common);

}  // namespace sliplab
