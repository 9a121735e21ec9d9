#include "bridges/mqtt/states.hpp"

#include <algorithm>
#include <utility>

#include "bridges/mqtt/messages.hpp"
#include "clients/c/alert.hpp"

namespace slipd::mqtt {

bool States::take(slipd_estimate& estimate, std::string text, Time now) {
  const bool first = !states_.contains(estimate.name);
  State& state = state_of(estimate.name);
  if (estimate.alert != SLIPD_ALERT_UNKNOWN)
    state.stands = estimate.alert;
  else if (client::is_raised(state.stands))
    estimate.alert = state.stands;
  const bool changed =
      first || estimate.state != state.estimate.state || estimate.alert != state.estimate.alert;
  state.is_new = state.is_new || changed;
  state.estimate = estimate;
  state.text = std::move(text);
  const std::chrono::duration<double> age(std::max(0.0, estimate.age_s));
  state.stale_at = age < times_.silence  // false for what never had a frame
                       ? now + times_.silence - std::chrono::duration_cast<std::chrono::nanoseconds>(age)
                       : now;
  return changed;
}

void States::lose(const std::string& name, std::string text) {
  State& state = state_of(name);
  slipd_estimate& estimate = state.estimate;
  name.copy(estimate.name, sizeof(estimate.name) - 1);
  grow_old(estimate);
  estimate.state = SLIPD_STATE_DISCONNECTED;
  estimate.alert = client::without_frames(state.stands);
  state.text = std::move(text);
  state.stale_at = Time::max();
  state.is_new = true;
}

int States::standing_alert(const std::string& name) const {
  const auto at = states_.find(name);
  if (at != states_.end()) return at->second.stands;
  return recorded_ ? recorded_(name) : int{SLIPD_ALERT_NONE};
}

States::State& States::state_of(const std::string& name) {
  const int stands = standing_alert(name);
  State& state = states_[name];
  state.stands = stands;
  return state;
}

std::vector<std::string> States::forget(const std::function<bool(const std::string& name)>& gone) {
  std::vector<std::string> names;
  for (const auto& [name, state] : states_)
    if (gone(name)) names.push_back(name);
  for (const std::string& name : names) states_.erase(name);
  return names;
}

void States::say_due(Time now, const std::function<void(const State& state)>& say) {
  for (auto& [name, state] : states_) {
    if (state.stale_at <= now) {
      const int before = state.estimate.state, alert = state.estimate.alert;
      grow_old(state.estimate);
      state.stale_at = Time::max();
      state.is_new = state.is_new || before != state.estimate.state || alert != state.estimate.alert;
    }
    if (!state.is_new && now < state.said_at + times_.period) continue;
    state.is_new = false;
    state.said_at = now;
    say(state);
  }
}

States::Time States::next() const {
  Time next = next_stale();
  for (const auto& [name, state] : states_)
    next = std::min(next, state.is_new ? Time{} : state.said_at + times_.period);
  return next;
}

States::Time States::next_stale() const {
  Time next = Time::max();
  for (const auto& [name, state] : states_) next = std::min(next, state.stale_at);
  return next;
}

void States::renew() {
  for (auto& [name, state] : states_) state.is_new = true;
}

}  // namespace slipd::mqtt
