// What a slipd has and says, for a bridge: its sensors and grasps, and its estimates as they come, by
// libslipd. It connects again by itself. One thread's own: that of the loop.
#pragma once

#include <chrono>
#include <functional>
#include <slipd.hpp>
#include <string>
#include <string_view>

#include "bridges/support/inventory.hpp"
#include "bridges/support/loop.hpp"

namespace slipd::bridges {

struct FeedOptions {
  // slipd's socket.
  std::string socket = SLIPD_SOCKET;
  // SLIPD_EVENT_… bits to subscribe to, of all sensors.
  int events = SLIPD_EVENT_ESTIMATE | SLIPD_EVENT_ALERT | SLIPD_EVENT_STATE;
  // Highest rate of estimates of one sensor, Hz; 0: all. slipd thins them, so a low rate costs little.
  double max_rate_hz = 0;
  // Whether FeedListener::estimate gets the text of an estimate. Without, none is made, which takes longer
  // than reading the estimate.
  bool texts = false;
  // Older estimates arrive as `stale`, without a margin, s. Less than a period of the sensor: every estimate
  // may be stale.
  double max_age_s = 0.1;
  // How often the inventory is asked for, which finds what a reload changed and a slipd that is away. Too
  // small costs slipd requests; too large lets a change of the configuration wait.
  std::chrono::milliseconds refresh{5000};
  // How long slipd may take for one answer, s. The loop stands still meanwhile.
  double answer_timeout_s = 1;
  // The same, asked for before each request for the inventory, for a bridge that must not stand still for
  // longer than something else allows. Empty: answer_timeout_s.
  std::function<double()> patience_s = {};
};

struct FeedListener {
  // slipd serves, with this inventory: after connecting, and when the inventory has changed. May be empty.
  std::function<void(const Inventory&)> serves;
  // slipd is away; `why` is libslipd's text. Once for each time that it goes, and at the start if it is not
  // there. May be empty.
  std::function<void(std::string_view why)> away;
  // An estimate. `estimate.event` says which event it is; `text` is the JSON object that slipd sent
  // (docs/socket.md), whose age and state were those at sending; empty without FeedOptions::texts. After
  // `serves`, and for a sensor of its inventory.
  std::function<void(const slipd_estimate& estimate, std::string_view text)> estimate;
};

class Feed {
 public:
  // Connects from the loop; slipd need not run. Throws std::bad_alloc, std::system_error.
  Feed(Loop& loop, FeedOptions options, FeedListener listener);
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  // FeedOptions::max_rate_hz from now on. Estimates that came while slipd changed it may be missing.
  void limit_rate(double max_rate_hz);
  bool connected() const noexcept { return connected_; }
  // The last one, also while slipd is away.
  const Inventory& inventory() const noexcept { return inventory_; }
  // For further calls of libslipd, such as slipd_attach and slipd_latest.
  slipd_client* client() const noexcept { return slipd_.get(); }

 private:
  void refresh();
  void subscribe();
  void take_events();
  void take(const slipd_estimate& estimate);
  bool ask();
  void lose(std::string_view why);

  FeedOptions options_;
  FeedListener listener_;
  client::Connection slipd_;
  Inventory inventory_;
  bool connected_ = false;
  bool told_ = false;  // of being connected or away
  bool subscribed_ = false;
  double subscribed_rate_hz_ = 0;
  Loop::Timer timer_;
  Loop::Timer rest_;  // takes the estimates that are left, once other handlers have run
  Loop::Watch watch_;
};

}  // namespace slipd::bridges
