#include "bridges/mqtt/publisher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bridges/support/clock.hpp"
#include "bridges/support/log.hpp"

namespace slipd::mqtt {
namespace {

using bridges::log;
using bridges::LogLevel;
using bridges::realtime_ns;
using Clock = std::chrono::steady_clock;

// A broker that has an alert for this long and does not acknowledge it is left.
constexpr std::chrono::seconds kAcknowledgeTimeout{20};
// Acknowledged alerts are removed from the disk after this long at the latest.
constexpr std::chrono::seconds kFlushPeriod{1};
// At the end: for the last messages.
constexpr std::chrono::milliseconds kLeavePatience{500};
constexpr std::chrono::hours kSummaryWindow{1};
// Times of alerts that are kept to count those of the last hour.
constexpr std::size_t kMostAlertTimes = 100'000;

}  // namespace

Publisher::Publisher(Settings settings, std::string version, bridges::Loop& loop)
    : settings_(std::move(settings)),
      version_(std::move(version)),
      loop_(loop),
      store_(settings_.store, settings_.max_alerts),
      turns_(settings_.brokers.size()),
      random_(std::random_device{}()),
      progress_at_(Clock::now()),
      told_dropped_(store_.dropped()),
      connecting_(loop, [this] { connect(); }),
      summary_(loop, [this] { put_summary(); }),
      flush_(loop, [this] { check_progress(); }),
      feed_(loop, feed_options(), feed_listener()) {
  if (store_.waiting() > 0)
    log(LogLevel::info, std::to_string(store_.waiting()) + " alerts wait from before");
  connecting_.start({});
  summary_.start(settings_.summary);
  flush_.start(kFlushPeriod);
}

Publisher::~Publisher() {
  if (!broker_ || !broker_->accepted()) return;
  broker_->publish(host_topic("status"), offline_message(realtime_ns()), 1, true);
  broker_->leave(kLeavePatience);
}

bridges::FeedOptions Publisher::feed_options() const {
  bridges::FeedOptions options;
  options.socket = settings_.socket;
  options.max_rate_hz = settings_.rate_hz;
  options.max_age_s = settings_.max_age_s;
  options.texts = true;
  return options;
}

bridges::FeedListener Publisher::feed_listener() {
  bridges::FeedListener listener;
  listener.serves = [this](const bridges::Inventory& inventory) { note_serving(inventory); };
  listener.away = [this](std::string_view why) { note_away(why); };
  listener.estimate = [this](const slipd_estimate& estimate, std::string_view text) { take(estimate, text); };
  return listener;
}

// When a message of it would show a margin that has expired.
std::chrono::steady_clock::time_point Publisher::expiry_of(const slipd_estimate& estimate) const {
  if (estimate.state != SLIPD_STATE_OK) return Clock::time_point::max();
  const std::chrono::duration<double> left(std::max(0.0, settings_.max_age_s - estimate.age_s));
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(left);
}

void Publisher::take(const slipd_estimate& estimate, std::string_view text) {
  latest_[estimate.name] = estimate;
  if (estimate.event == SLIPD_EVENT_ALERT) {
    take_alert(estimate, text);
  } else if (estimate.event == SLIPD_EVENT_ESTIMATE) {
    put(topic_of(estimate.name, "estimate"), {estimate_message(estimate, text), false, expiry_of(estimate)});
  }
  if (estimate.event != SLIPD_EVENT_ESTIMATE || !states_.contains(estimate.name))
    note_state(estimate.name, state_message(estimate, text));
  send();
}

void Publisher::take_alert(const slipd_estimate& estimate, std::string_view text) {
  if (estimate.alert != SLIPD_ALERT_NONE && alert_times_.size() < kMostAlertTimes)
    alert_times_.push_back(Clock::now());
  store_.append(topic_of(estimate.name, "alert"), [&](std::int64_t number, std::int64_t dropped) {
    return alert_message(text, store_.series(), number, dropped);
  });
  if (store_.dropped() == told_dropped_) return;
  if (told_dropped_ == 0 || !store_.trouble().empty())
    log(LogLevel::error, settings_.store.string() + ": alerts are dropped: " +
                             (store_.trouble().empty() ? "the store is full" : store_.trouble()));
  told_dropped_ = store_.dropped();
  put_status();
}

void Publisher::note_serving(const bridges::Inventory& inventory) {
  if (!slipd_) log(LogLevel::info, "slipd serves " + std::to_string(inventory.sensors.size()) + " sensors");
  slipd_ = inventory;
  trouble_.clear();
  std::erase_if(latest_, [&](const auto& each) { return !inventory.has_sensor(each.first); });
  std::erase_if(states_, [&](const auto& each) {
    const bool gone = !inventory.has_sensor(each.first);
    if (gone) put_retained(topic_of(each.first, "state"), "");  // the broker forgets the topic
    return gone;
  });
  put_status();
  send();
}

void Publisher::note_away(std::string_view why) {
  log(LogLevel::warning, why);
  if (slipd_) {
    for (const auto& sensor : slipd_->sensors)
      note_state(sensor.name, away_message(sensor.name, realtime_ns()));
  }
  slipd_.reset();
  trouble_ = why;
  latest_.clear();
  put_status();
  send();
}

void Publisher::note_state(const std::string& sensor, std::string payload) {
  states_[sensor] = payload;
  put_retained(topic_of(sensor, "state"), std::move(payload));
}

void Publisher::connect() {
  const BrokerSettings& next = settings_.brokers[turns_.current()];
  BrokerListener listener;
  listener.accepted = [this] { note_accepted(); };
  listener.acknowledged = [this](int message) { note_acknowledged(message); };
  listener.writable = [this] { send(); };
  listener.lost = [this](const std::string& why) { note_lost(why); };
  const LastWill will{host_topic("status"), offline_message(0)};
  broker_ =
      std::make_unique<Broker>(loop_, next, settings_.topic_prefix + "-" + settings_.host, will, listener);
}

// All retained topics are published anew: the broker may be another one.
void Publisher::note_accepted() {
  const BrokerSettings& broker = settings_.brokers[turns_.current()];
  log(LogLevel::info, broker.host + ":" + std::to_string(broker.port) + ": accepted, " +
                          std::to_string(store_.waiting()) + " alerts wait");
  store_.flush();
  on_their_way_.clear();
  sent_ = 0;
  progress_at_ = Clock::now();
  put_status();
  for (const auto& [sensor, payload] : states_) put_retained(topic_of(sensor, "state"), payload);
  put_summary();
  send();
}

void Publisher::note_acknowledged(int message) {
  const auto found = on_their_way_.find(message);
  if (found == on_their_way_.end()) return;  // of QoS 0: it is written
  store_.acknowledge(found->second);
  on_their_way_.erase(found);
  progress_at_ = Clock::now();
  send_alerts();
}

void Publisher::note_lost(const std::string& why) {
  log(LogLevel::warning, why);
  const auto held = broker_->held();
  broker_.reset();
  on_their_way_.clear();
  const double share = static_cast<double>(random_()) / static_cast<double>(std::minstd_rand::max());
  connecting_.start(turns_.lost(held, share));
}

void Publisher::check_progress() {
  flush_.start(kFlushPeriod);
  store_.flush();
  if (on_their_way_.empty() || Clock::now() - progress_at_ < kAcknowledgeTimeout) return;
  note_lost("the broker does not acknowledge alerts");
}

void Publisher::put(const std::string& topic, Pending message) {
  pending_[topic] = std::move(message);
}

void Publisher::put_retained(const std::string& topic, std::string payload) {
  put(topic, {std::move(payload), true});
}

void Publisher::put_status() {
  put_retained(host_topic("status"), online_message(gripper(), realtime_ns()));
}

void Publisher::put_summary() {
  summary_.start(settings_.summary);
  std::map<std::string, SensorLine> lines;
  for (const auto& [name, estimate] : latest_) {
    const double gamma = slipd_margin(&estimate);
    const bool young = estimate.state != SLIPD_STATE_OK || !std::isnan(gamma);
    lines[name] = {slipd_state_name(young ? estimate.state : int{SLIPD_STATE_STALE}),
                   slipd_alert_name(estimate.alert), gamma};
  }
  put_retained(host_topic("summary"), summary_message(gripper(), lines, alerts_last_hour(), realtime_ns()));
  send();
}

// Alerts first. The rest while the broker takes it: what it does not take stays in its place.
void Publisher::send() {
  send_alerts();
  while (!pending_.empty() && broker_ && broker_->writable()) {
    const auto next = pending_.extract(pending_.begin());
    const Pending& message = next.mapped();
    if (Clock::now() <= message.expires) broker_->publish(next.key(), message.payload, 0, message.retain);
  }
}

void Publisher::send_alerts() {
  while (broker_ && broker_->writable() && on_their_way_.size() < kWindow) {
    const auto next = store_.after(sent_);
    if (!next) return;
    if (on_their_way_.empty()) progress_at_ = Clock::now();
    const int message = broker_->publish(next->topic, next->payload, 1, false);
    if (message == 0) return;
    on_their_way_[message] = next->number;
    sent_ = next->number;
  }
}

std::string Publisher::topic_of(const std::string& sensor, const char* kind) const {
  return settings_.topic_prefix + "/" + settings_.host + "/" + sensor + "/" + kind;
}

std::string Publisher::host_topic(const char* kind) const {
  return settings_.topic_prefix + "/" + settings_.host + "/" + kind;
}

Gripper Publisher::gripper() const {
  return {version_, slipd_, {store_.series(), store_.last(), store_.waiting(), store_.dropped()}, trouble_};
}

std::int64_t Publisher::alerts_last_hour() {
  const auto begin = Clock::now() - kSummaryWindow;
  while (!alert_times_.empty() && alert_times_.front() < begin) alert_times_.pop_front();
  return static_cast<std::int64_t>(alert_times_.size());
}

}  // namespace slipd::mqtt
