// What is known of each sensor and grasp, which alert of it stands, and when its retained topic `state` is
// due: at each change, once a period, and when slipd has fallen silent. It has no clock. One thread's
// own.
#pragma once

#include <slipd.h>

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace slipd::mqtt {

struct StateTimes {
  // An estimate that is older is stale.
  std::chrono::nanoseconds silence{};
  // A state that has not changed is said again after this long.
  std::chrono::nanoseconds period{};
};

class States {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct State {
    // The last one, with the alert that stands and the state of now.
    slipd_estimate estimate{};
    // What slipd sent, or away_text().
    std::string text;
    // Last alert that was known: none, warn or slip.
    int stands = SLIPD_ALERT_NONE;
    // When estimate is stale, and when it was said.
    Time stale_at{}, said_at{};
    // Not said yet.
    bool is_new = true;
  };

  // `recorded`: the alert of a name that was recorded last, none, warn or slip, which stands until something
  // of the name is known; empty: none.
  explicit States(StateTimes times, std::function<int(const std::string& name)> recorded = {})
      : times_(times), recorded_(std::move(recorded)) {}

  // What slipd said, with its text. An alert that was raised stands where slipd does not know one: `estimate`
  // has it then. True: state or alert are others than before.
  bool take(slipd_estimate& estimate, std::string text, Time now);
  // slipd is away. `text`: away_text().
  void lose(const std::string& name, std::string text);

  // The alert of this name that was known last: none, warn or slip.
  int standing_alert(const std::string& name) const;
  // By name.
  const std::map<std::string, State>& all() const noexcept { return states_; }
  // Forgets those that `gone` names, and returns their names.
  std::vector<std::string> forget(const std::function<bool(const std::string& name)>& gone);

  // Calls `say` for each state that is due.
  void say_due(Time now, const std::function<void(const State& state)>& say);
  // When the next one is due; Time::max(): none.
  Time next() const;
  // When the next one becomes stale; Time::max(): none.
  Time next_stale() const;
  // All are due.
  void renew();

 private:
  State& state_of(const std::string& name);

  std::map<std::string, State> states_;
  StateTimes times_;
  std::function<int(const std::string& name)> recorded_;
};

}  // namespace slipd::mqtt
