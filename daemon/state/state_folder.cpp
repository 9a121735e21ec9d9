#include "daemon/state/state_folder.hpp"

#include <cstdlib>
#include <stdexcept>

namespace slipd {
namespace {

namespace fs = std::filesystem;

fs::path from_environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread changes the environment
  return value != nullptr ? fs::path(value) : fs::path();
}

}  // namespace

fs::path state_folder() {
  if (auto state = from_environment("STATE_DIRECTORY"); !state.empty()) return state;
  if (const auto state = from_environment("XDG_STATE_HOME"); !state.empty()) return state / "slipd";
  if (const auto home = from_environment("HOME"); !home.empty()) return home / ".local" / "state" / "slipd";
  throw std::runtime_error("no place to keep anything: set STATE_DIRECTORY, XDG_STATE_HOME or HOME");
}

}  // namespace slipd
