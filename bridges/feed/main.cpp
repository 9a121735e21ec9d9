// slipd-feed's command line; slipd-feed(8).
#include "bridges/feed/feeds.hpp"
#include "embedded/slipd_feed_schema.hpp"

int main(int argc, char** argv) {
  using namespace slipd;
  return bridges::run_program(
      {"slipd-feed", "Sends slipd the frames of sensors on networks", slipd_feed_schema,
       feed::further_problems},
      argc, argv,
      [](const nlohmann::json& settings, bridges::Loop& loop) -> std::unique_ptr<bridges::Service> {
        return std::make_unique<feed::Feeds>(feed::settings_of(settings), loop);
      });
}
