// Estimates of a real slipd in a bridge's loop.
#include "bridges/support/feed.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <stdexcept>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

// Each estimate is handled only when the next one has come, as in a bridge that is too slow for its sensors.
TEST(Feed, OfABridgeThatIsTooSlowLeavesSignalsAndTimersTheirTurn) {
  const TempFolder folder;
  const auto config = config_with(folder, nlohmann::json::array({trial_sensor("left")}));
  const Daemon slipd(config, trial_drivers());
  bridges::Loop loop;
  bool had_its_turn = false;
  bridges::Loop::Timer other(loop, [&] {
    had_its_turn = true;
    loop.stop();
  });
  const bridges::Feed* self = nullptr;
  int estimates = 0;
  const auto handle = [&](const slipd_estimate&, std::string_view) {
    constexpr int kEndless = 1000;
    if (++estimates == 1) other.start({});
    if (estimates > kEndless) throw std::runtime_error("nothing else has its turn");
    pollfd more{.fd = slipd_fd(self->client()), .events = POLLIN, .revents = 0};
    ::poll(&more, 1, 10'000);
  };
  bridges::FeedListener listener;
  listener.estimate = handle;
  bridges::Feed feed(loop, {.socket = config["socket"]["path"]}, listener);
  self = &feed;
  loop.run();
  EXPECT_TRUE(had_its_turn);
}

}  // namespace
}  // namespace slipd::testing
