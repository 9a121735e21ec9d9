// The environment that slipd was started in. Any thread: nobody changes it.
#pragma once

#include <cstdlib>
#include <string>

namespace slipd {

// Empty: the variable is not set.
inline std::string environment_variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread changes the environment
  return value != nullptr ? value : "";
}

}  // namespace slipd
