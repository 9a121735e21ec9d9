// slipd-modbus's command line; slipd-modbus(8).
#include "bridges/modbus/server.hpp"
#include "embedded/slipd_modbus_schema.hpp"

int main(int argc, char** argv) {
  using namespace slipd;
  return bridges::run_program(
      {"slipd-modbus", "Serves slipd's estimates as Modbus TCP input registers", slipd_modbus_schema}, argc,
      argv, [](const nlohmann::json& settings, bridges::Loop& loop) -> std::unique_ptr<bridges::Service> {
        return std::make_unique<modbus::Server>(modbus::server_settings_of(settings), loop);
      });
}
