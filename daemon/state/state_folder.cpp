#include "daemon/state/state_folder.hpp"

#include <stdexcept>

#include "daemon/rt/environment.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;

fs::path from_environment(const char* name) {
  return environment_variable(name);
}

}  // namespace

fs::path state_folder() {
  if (auto state = from_environment("STATE_DIRECTORY"); !state.empty()) return state;
  if (const auto state = from_environment("XDG_STATE_HOME"); !state.empty()) return state / "slipd";
  if (const auto home = from_environment("HOME"); !home.empty()) return home / ".local" / "state" / "slipd";
  throw std::runtime_error("no place to keep anything: set STATE_DIRECTORY, XDG_STATE_HOME or HOME");
}

}  // namespace slipd
