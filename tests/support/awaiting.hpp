// Waiting for an event that another program or thread does not tell.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/patience.hpp"

namespace slipd::testing {

// Until `condition()` holds. A fatal failure if it never does.
template <class Condition>
void await_true(const Condition& condition) {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now(), until);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace slipd::testing
