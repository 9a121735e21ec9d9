// Waits until a program under test has printed something. False, and a failure of the test, if it has not
// after kPatience, or has ended without.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <thread>

#include "tests/support/patience.hpp"
#include "tests/support/program.hpp"

namespace slipd::testing {

// Whether `text` is in what `printed` returns, after its first `from` bytes.
inline bool await_text(Program& program, std::string (Program::*printed)() const, const std::string& text,
                       std::size_t from = 0) {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    const bool ended = program.wait(std::chrono::milliseconds(0)).has_value();  // before what it printed last
    if ((program.*printed)().find(text, from) != std::string::npos) return true;
    if (ended || std::chrono::steady_clock::now() > until) {
      ADD_FAILURE() << "\"" << text << "\" is not printed: " << program.output() << program.errors();
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

// The same of its output.
inline bool await_output(Program& program, const std::string& text, std::size_t from = 0) {
  return await_text(program, &Program::output, text, from);
}

// The same of its errors.
inline bool await_errors(Program& program, const std::string& text) {
  return await_text(program, &Program::errors, text);
}

}  // namespace slipd::testing
