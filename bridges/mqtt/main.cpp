// slipd-mqtt's command line; slipd-mqtt(8).
#include "bridges/mqtt/publisher.hpp"
#include "bridges/mqtt/settings.hpp"
#include "bridges/support/program.hpp"
#include "embedded/slipd_mqtt_schema.hpp"

int main(int argc, char** argv) {
  using namespace slipd;
  return bridges::run_program(
      {"slipd-mqtt", "Publishes slipd's estimates, states and alerts to an MQTT broker", slipd_mqtt_schema,
       mqtt::further_problems},
      argc, argv,
      [](const nlohmann::json& settings, bridges::Loop& loop) -> std::unique_ptr<bridges::Service> {
        return std::make_unique<mqtt::Publisher>(mqtt::settings_of(settings), SLIPD_VERSION, loop);
      });
}
