#include "daemon/rpc/clients/subscription.hpp"

#include <algorithm>
#include <string>

#include "daemon/rpc/protocol/request_params.hpp"
#include "daemon/rpc/protocol/rpc.hpp"

namespace slipd {
namespace {

constexpr const char* kKindNames[kEventKinds] = {"estimate", "alert", "state"};

}  // namespace

Subscription::Subscription(int id, const nlohmann::json& params, const Board& board) : id_(id) {
  if (const auto sensors = params.find("sensors"); sensors != params.end() && !sensors->is_null()) {
    if (!sensors->is_array()) throw rpc::Error(rpc::kInvalidParams, "\"sensors\" must be a list of names");
    std::vector<bool> named(board.sensors.size());  // each once, however often the client names it
    for (const nlohmann::json& name : *sensors) named[sensor_index(name, board)] = true;
    names_.emplace();
    for (std::size_t i = 0; i < named.size(); ++i) {
      if (named[i]) names_->push_back(board.sensors[i]->name);
    }
  }
  rebind(board);
  if (const auto rate = params.find("max_rate_hz"); rate != params.end() && !rate->is_null()) {
    const double hz = rate->is_number() ? rate->get<double>() : 0;
    if (!(hz >= 0.001 && hz <= 1e6))
      throw rpc::Error(rpc::kInvalidParams, "\"max_rate_hz\" must be 0.001 to 1000000 Hz");
    interval_ns_ = static_cast<std::int64_t>(1e9 / hz);
  }
  const nlohmann::json events = params.value("events", nlohmann::json{"estimate"});
  if (!events.is_array())
    throw rpc::Error(rpc::kInvalidParams, "\"events\" must be a list of estimate, alert, state");
  for (const nlohmann::json& event : events) {
    const auto* const kind = std::find_if(std::begin(kKindNames), std::end(kKindNames),
                                          [&](const char* name) { return event == name; });
    if (kind == std::end(kKindNames)) {
      throw rpc::Error(rpc::kInvalidParams,
                       "there is no event " + event.dump() + "; there are estimate, alert and state");
    }
    events_[kind - kKindNames] = true;
  }
}

void Subscription::rebind(const Board& board) {
  sensors_.assign(board.sensors.size(), Delivery{});
  for (std::size_t i = 0; i < sensors_.size(); ++i) sensors_[i].wanted = selects(board.sensors[i]->name);
}

bool Subscription::selects(const std::string& sensor) const {
  return !names_ || std::find(names_->begin(), names_->end(), sensor) != names_->end();
}

bool Subscription::wants(const std::string& sensor, EventKind kind) const {
  return events_[static_cast<std::size_t>(kind)] && selects(sensor);
}

bool Subscription::accepts(const Event& event, EventKind kind, std::uint64_t& lost) {
  Delivery& delivery = sensors_[event.sensor];
  if (!delivery.wanted || !events_[static_cast<std::size_t>(kind)]) return false;
  if (kind != EventKind::estimate) {
    lost = 0;
    return true;
  }
  delivery.lost += event.lost_before;
  const std::int64_t now_ns = event.estimate.published_ns;
  const bool changed = !delivery.sent_any || delivery.state != event.estimate.state;
  if (!changed && now_ns < delivery.next_due_ns) return false;
  // The next one is due one interval after this one was due, which keeps the mean rate; at least half an
  // interval from now, which excludes bursts.
  delivery.next_due_ns = std::max(delivery.next_due_ns + interval_ns_, now_ns);
  if (interval_ns_ > 0 && delivery.next_due_ns < now_ns + interval_ns_ / 2)
    delivery.next_due_ns = now_ns + interval_ns_;
  delivery.sent_any = true;
  delivery.state = event.estimate.state;
  lost = std::exchange(delivery.lost, 0);
  return true;
}

}  // namespace slipd
