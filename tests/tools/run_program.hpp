// Runs a program to its end and keeps what it printed.
#pragma once

#include <string>
#include <vector>

namespace slipctl::testing {

struct Ran {
  int exit_code = -1;  // 128 + signal, if one ended it
  std::string out, err;
};

// `arguments` without the program's own name. stdin is empty, stdout and stderr are files.
Ran run_program(const std::string& program, const std::vector<std::string>& arguments);

// slipctl of this build.
Ran slipctl_with(const std::vector<std::string>& arguments);
std::string slipctl_program();

}  // namespace slipctl::testing
