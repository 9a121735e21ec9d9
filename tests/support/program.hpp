// A program under test: starts it, stops it, waits for it, keeps its output.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/patience.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::testing {

class Program {
 public:
  using Environment = std::vector<std::pair<std::string, std::string>>;

  // Starts it. Output and errors go to files in `folder`, named after `name`.
  Program(const TempFolder& folder, const std::string& name, std::vector<std::string> command,
          const Environment& environment = {});
  ~Program();  // kills it if it still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const;

  // The exit code, 128 + n for signal n; none if it still runs after `patience`.
  std::optional<int> wait(std::chrono::milliseconds patience = kPatience);

  std::string output() const;
  std::string errors() const;

 private:
  std::filesystem::path output_, errors_;
  pid_t pid_ = -1;
  std::optional<int> code_;
};

// The folder of the programs of this build.
std::filesystem::path program_folder();

// Runs a program to its end. Fails the test if it does not end.
struct Ran {
  int code = -1;
  std::string output, errors;
};
Ran run(std::vector<std::string> command, const Program::Environment& environment = {});

}  // namespace slipd::testing
