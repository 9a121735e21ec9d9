// slipd-web: a page in a browser that shows what slipd says. man slipd-web(8), docs/web.md.
#include <memory>

#include "bridges/support/program.hpp"
#include "bridges/web/reader.hpp"
#include "bridges/web/settings.hpp"
#include "embedded/slipd_web_schema.hpp"

int main(int argc, char** argv) {
  using namespace slipd;
  const bridges::Program program{"slipd-web", "Shows margins, health and recordings in a browser",
                                 slipd_web_schema, web::further_problems};
  return bridges::run_program(program, argc, argv, [](const nlohmann::json& settings, bridges::Loop& loop) {
    return std::make_unique<web::Reader>(loop, web::settings_from(settings));
  });
}
