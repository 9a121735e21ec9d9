// Waits until a program under test has printed something.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "tests/support/patience.hpp"
#include "tests/support/program.hpp"

namespace slipd::testing {

// Whether `text` is in the program's output after `from`, at the latest after kPatience. False at once if the
// program has ended without.
inline bool await_output(Program& program, const std::string& text, std::size_t from = 0) {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    const bool ended = program.wait(std::chrono::milliseconds(0)).has_value();
    if (program.output().find(text, from) != std::string::npos) return true;
    if (ended || std::chrono::steady_clock::now() > until) {
      ADD_FAILURE() << "\"" << text << "\" is not printed: " << program.output() << program.errors();
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace slipd::testing
