#include "bridges/mqtt/fleet.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <utility>

namespace slipd::mqtt {
namespace {

using Json = nlohmann::ordered_json;

// Larger payloads are none of slipd-mqtt's.
constexpr std::size_t kLargestPayload = std::size_t{1} << 20;
// A summary is too old after so many of its periods.
constexpr double kPeriods = 2;

// From the state that needs a person most to the one that needs nobody.
constexpr std::array<const char*, 9> kStates{
    "disconnected", "fault", "stale", "unzeroed", "out_of_model", "learning", "no_shear", "no_contact", "ok"};
constexpr std::array<const char*, 4> kAlerts{"slip", "warn", "unknown", "none"};

// The member, null if there is none.
const Json& at(const Json& object, const char* key) {
  static const Json nothing;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found == object.end() ? nothing : *found;
}

std::string text_at(const Json& object, const char* key) {
  const Json& value = at(object, key);
  return value.is_string() ? value.get<std::string>() : std::string();
}

Json count_at(const Json& object, const char* key) {
  const Json& value = at(object, key);
  return value.is_number_unsigned() ? value : Json(nullptr);
}

// Place of a name in a list from worst to best; one that it has not is as bad as the worst.
template <typename List>
std::size_t place_of(const List& list, const std::string& name) {
  const auto found = std::find(list.begin(), list.end(), name);
  return found == list.end() ? 0 : static_cast<std::size_t>(found - list.begin());
}

// Age of a summary by the clocks of both machines; without a time it is too old for everything.
std::chrono::nanoseconds age_of(const Json& summary, std::int64_t realtime_ns) {
  constexpr std::chrono::hours kTooOld{24 * 365};
  const Json& time = at(summary, "time_ns");
  if (!time.is_number_unsigned() || time.get<std::uint64_t>() > std::numeric_limits<std::int64_t>::max())
    return kTooOld;
  return std::chrono::nanoseconds(std::abs(realtime_ns - time.get<std::int64_t>()));
}

// Names of the sensors and grasps of a status.
std::vector<std::string> names_of(const Json& status) {
  std::vector<std::string> names;
  for (const char* list : {"sensors", "grasps"}) {
    const Json& each = at(status, list);
    if (!each.is_array()) continue;
    for (const Json& one : each) {
      if (std::string name = text_at(one, "name"); !name.empty() && names.size() < Fleet::kMostNames)
        names.push_back(std::move(name));
    }
  }
  return names;
}

// The summary's line of a sensor or grasp; null if it has none.
const Json& line_of(const Json& summary, const std::string& name) {
  static const Json nothing;
  for (const auto& [list, key] : {std::pair{"sensors", "sensor"}, std::pair{"grasps", "grasp"}}) {
    const Json& lines = at(summary, list);
    if (!lines.is_array()) continue;
    for (const Json& line : lines)
      if (text_at(line, key) == name) return line;
  }
  return nothing;
}

}  // namespace

Fleet::Fleet(std::string prefix) : prefix_(std::move(prefix)) {}

std::vector<std::string> Fleet::filters() const {
  return {prefix_ + "/+/status", prefix_ + "/+/summary", prefix_ + "/+/seen", prefix_ + "/+/+/state"};
}

std::string Fleet::take(std::string_view topic, std::string_view payload, bool retained, const Moment& now) {
  if (payload.size() > kLargestPayload || !topic.starts_with(prefix_ + "/")) return {};
  topic.remove_prefix(prefix_.size() + 1);
  std::string name(topic.substr(0, topic.find('/')));
  const std::string_view rest = topic.substr(std::min(topic.size(), name.size() + 1));
  const auto slash = rest.find('/');
  const bool of_host = rest == "status" || rest == "summary" || rest == "seen";
  if (name.empty() || (!of_host && (slash == std::string_view::npos || rest.substr(slash) != "/state")))
    return {};
  if (!grippers_.contains(name) && (payload.empty() || grippers_.size() >= kMostGrippers)) return {};
  Gripper& gripper = grippers_[name];
  Json message = payload.empty() ? Json() : Json::parse(payload, nullptr, false);
  if (!message.is_object()) message = nullptr;
  if (!of_host) {
    std::string subject(rest.substr(0, slash));
    if (message.is_null())
      gripper.states.erase(subject);
    else if (gripper.states.size() < kMostNames || gripper.states.contains(subject))
      gripper.states[std::move(subject)] = std::move(message);
  } else if (rest == "status") {
    gripper.status = std::move(message);
  } else if (rest == "seen") {
    gripper.seen = std::move(message);
  } else {
    gripper.made = now.steady - (retained ? age_of(message, now.realtime_ns) : std::chrono::nanoseconds(0));
    gripper.summary = std::move(message);
  }
  if (gripper.status.is_null() && gripper.summary.is_null() && gripper.seen.is_null() && payload.empty())
    grippers_.erase(name);
  return name;
}

std::vector<std::string> Fleet::grippers() const {
  std::vector<std::string> names;
  for (const auto& [name, gripper] : grippers_) names.push_back(name);
  return names;
}

bool Fleet::online(const Gripper& gripper) {
  return text_at(gripper.status, "status") == "online";
}

bool Fleet::is_fresh(const Gripper& gripper, const Moment& now) {
  const Json& period = at(gripper.summary, "period_s");
  if (!period.is_number()) return false;
  return std::chrono::duration<double>(now.steady - gripper.made).count() <= kPeriods * period.get<double>();
}

// A sensor that has said nothing yet is stale.
Fleet::Worst Fleet::worst_of(const Gripper& gripper) {
  Worst worst{"ok", nullptr, true};
  std::size_t place = kStates.size();
  for (const std::string& name : names_of(gripper.status)) {
    const auto found = gripper.states.find(name);
    std::string state = found == gripper.states.end() ? "stale" : text_at(found->second, "state");
    if (std::find(kStates.begin(), kStates.end(), state) == kStates.end()) state = "fault";  // of no slipd
    worst.all_known = worst.all_known && (state == "ok" || state == "no_contact");
    // A margin is worth more than no contact: with both, the gripper's state is ok.
    const std::size_t here = state == "no_contact" ? kStates.size() - 1 : place_of(kStates, state);
    if (here < place || (state == "ok" && worst.state == "no_contact")) {
      worst.state = state;
      worst.name = name;
      place = here;
    }
  }
  if (worst.name.is_null()) worst = {"stale", nullptr, false};  // it has no sensors
  return worst;
}

// `watched`: what the states say holds. Otherwise a raised alert stands, and that there is none is unknown.
const char* Fleet::worst_alert_of(const Gripper& gripper, bool watched) {
  constexpr std::size_t kUnknown = 2;
  std::size_t worst = watched ? kAlerts.size() - 1 : kUnknown;
  const auto take = [&](const Json& state) {
    worst = std::min(worst, state.is_null() ? kUnknown : place_of(kAlerts, text_at(state, "alert")));
  };
  if (at(gripper.status, "slipd").is_string()) {
    for (const std::string& name : names_of(gripper.status)) {
      const auto found = gripper.states.find(name);
      take(found == gripper.states.end() ? Json() : found->second);
    }
  } else {  // it does not say what it has
    for (const auto& [name, state] : gripper.states) take(state);
  }
  return kAlerts[worst];
}

void Fleet::add_margin(const Gripper& gripper, Json& line) {
  double least = 2;  // above every margin
  for (const std::string& name : names_of(gripper.status)) {
    const auto found = gripper.states.find(name);
    if (found == gripper.states.end() || text_at(found->second, "state") != "ok") continue;
    const Json& gamma = at(line_of(gripper.summary, name), "gamma_min");
    if (!gamma.is_number()) {  // it has a margin, which no summary has yet
      line["gamma"] = line["gamma_of"] = nullptr;
      return;
    }
    if (gamma.get<double>() >= least) continue;
    least = gamma.get<double>();
    line["gamma"] = gamma;
    line["gamma_of"] = name;
  }
}

void Fleet::add_counts(const Gripper& gripper, bool fresh, Json& line) {
  const Json& counts = at(gripper.summary, "alerts");
  line["alerts_last_hour"] = fresh ? count_at(gripper.summary, "alerts_last_hour") : Json(nullptr);
  line["alerts_waiting"] = fresh ? count_at(counts, "waiting") : Json(nullptr);
  line["alerts_dropped"] = fresh ? count_at(counts, "dropped") : Json(nullptr);
  const Json& version = at(gripper.status, "slipd");
  const Json& before = at(gripper.seen, "version");
  line["version"] = version.is_string() ? version : before.is_string() ? before : Json(nullptr);
  line["simulated"] = nullptr;
  const Json& sensors = at(gripper.status, "sensors");
  if (!sensors.is_array()) return;
  line["simulated"] = std::any_of(sensors.begin(), sensors.end(),
                                  [](const Json& sensor) { return at(sensor, "simulated") == true; });
}

std::string Fleet::line(const std::string& name, const Moment& now) const {
  Json line{{"gripper", name}};
  const auto found = grippers_.find(name);
  if (found == grippers_.end()) {
    line["status"] = "removed";
    return line.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  const Gripper& gripper = found->second;
  const bool is_online = online(gripper);
  const bool is_offline = text_at(gripper.status, "status") == "offline";
  const bool fresh = is_online && is_fresh(gripper, now);
  const bool served = is_online && at(gripper.status, "slipd").is_string();
  const Worst worst = served ? worst_of(gripper) : Worst{"disconnected", nullptr, false};
  line["status"] = is_online ? "online" : is_offline ? "offline" : "unknown";
  // Without a summary nobody says that what the states say still holds.
  const bool silent = served && !fresh && worst.all_known;
  line["state"] = silent ? "stale" : worst.state;
  line["state_of"] = silent ? Json(nullptr) : worst.name;
  line["gamma"] = line["gamma_of"] = nullptr;
  if (served && fresh && worst.all_known) add_margin(gripper, line);
  line["alert"] = worst_alert_of(gripper, served && fresh && !worst.name.is_null());
  add_counts(gripper, fresh, line);
  line["offline_since_ns"] = nullptr;
  if (is_offline) {
    const Json& end = at(gripper.status, "time_ns");
    line["offline_since_ns"] = end.is_number_integer() ? end : at(gripper.seen, "time_ns");
  }
  return line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace slipd::mqtt
