// What the commands of sliplab and slipd-lab share: their common options, and the program around them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>

namespace CLI {
class App;
}

namespace offline {

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

// The program `name` of the commands that `add` adds, one of which runs while the command line is parsed.
// Returns the exit code: 0 success, 1 failure, 2 wrong use.
int run_program(int argc, char** argv, const char* name, const char* description,
                void (*add)(CLI::App& app, const Common& common));

// Joins the parts that shards of a sweep have printed.
void add_merge(CLI::App& app);

}  // namespace offline
