// The skeleton of a bridge's program: command line, settings, signals, systemd. Its main() is one call:
//
//   int main(int argc, char** argv) {
//     return slipd::bridges::run_program({"slipd-mqtt", "slipd's estimates on MQTT", slipd_mqtt_schema},
//     argc, argv,
//                                        [](const nlohmann::json& settings, Loop& loop) {
//                                          return std::make_unique<Output>(settings, loop);
//                                        });
//   }
//
// Called from main, before any thread is started.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "bridges/support/loop.hpp"
#include "bridges/support/settings_file.hpp"

namespace slipd::bridges {

// A command-line option that sets a text of the settings, over what the file says.
struct Override {
  // As the user calls it: "--record".
  const char* option;
  // The key at the top of the settings.
  const char* key;
  // One sentence for --help.
  const char* help;
};

struct Program {
  // As the user calls it: "slipd-mqtt".
  const char* name;
  // One sentence for --help.
  const char* summary;
  // JSON Schema of the settings.
  std::string_view schema;
  // Rules that a schema cannot state.
  FurtherCheck further = {};
  // Beside the options that all programs have.
  std::vector<Override> overrides = {};
};

// What runs while the loop does: it serves from its constructor to its destructor.
class Service {
 public:
  virtual ~Service() = default;
};

// Makes the service. May throw std::exception; what() tells the user where, what, and what to do.
using MakeService = std::function<std::unique_ptr<Service>(const nlohmann::json& settings, Loop& loop)>;

// Handles --config FILE, --check-config, --version and --help, then serves until SIGTERM or SIGINT. SIGHUP
// reads the file again: the service is destroyed and made anew, or goes on as it was if the file has an
// error. Tells systemd READY, RELOADING and STOPPING. Returns the exit code: 0 done or stopped, 1 failed, 2
// wrong use or settings.
int run_program(const Program& program, int argc, char** argv, const MakeService& make);

}  // namespace slipd::bridges
