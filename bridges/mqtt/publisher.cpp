#include "bridges/mqtt/publisher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bridges/support/clock.hpp"
#include "bridges/support/log.hpp"
#include "clients/c/alert.hpp"

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
// From an alert to the summary that counts it: more alerts of this time are counted by the same summary.
constexpr std::chrono::seconds kSummaryAfterAlert{1};
// Between two requests for grasps. Too small: events of sensors in a row cost slipd a request each. Too
// large: a short alert of a grasp is missed.
constexpr std::chrono::milliseconds kGraspPause{10};
// Silence of slipd for which a state of a margin may stand, at least: a machine under load pauses.
constexpr std::chrono::milliseconds kLeastSilence{200};
// So many estimates come in this time from a sensor that is fast enough, so that one that is late is no
// silence.
constexpr double kEstimatesPerSilence = 4;
// How long slipd may take to answer, s, and at least, however soon a state is stale. The loop stands still
// meanwhile.
constexpr double kLongestPatience = 1, kLeastPatience = 0.05;

std::chrono::seconds in_seconds(Clock::duration duration) {
  return std::max(std::chrono::seconds(1), std::chrono::ceil<std::chrono::seconds>(duration));
}

}  // namespace

Publisher::Publisher(Settings settings, std::string version, bridges::Loop& loop)
    : settings_(std::move(settings)),
      version_(std::move(version)),
      loop_(loop),
      store_(settings_.store, settings_.max_alerts),
      tried_(settings_.store.string() + ".broker"),
      turns_(settings_.brokers.size(), {}, first_broker()),
      random_(std::random_device{}()),
      states_({silence(), settings_.summary},
              [this](const std::string& name) { return store_.standing(topic_of(name, "alert")); }),
      progress_at_(Clock::now()),
      told_dropped_(store_.dropped()),
      connecting_(loop, [this] { connect(); }),
      summary_(loop, [this] { put_summary(); }),
      flush_(loop, [this] { check_progress(); }),
      asking_(loop, [this] { ask_grasps(); }),
      saying_(loop, [this] { send(); }),
      feed_(loop, feed_options(), feed_listener()) {
  if (store_.waiting() > 0)
    log(LogLevel::info, std::to_string(store_.waiting()) + " alerts wait from before");
  connecting_.start({});
  summary_.start(settings_.summary);
  flush_.start(kFlushPeriod);
}

Publisher::~Publisher() {
  if (!broker_ || !broker_->accepted()) return;
  lose_states();
  for (const auto& [name, state] : states_.all())
    broker_->publish(topic_of(name, "state"), state_message(state.estimate, state.text, valid_for()), 0, true,
                     in_seconds(valid_for()));
  broker_->publish(host_topic("status"), offline_message(realtime_ns()), 1, true);
  broker_->leave(kLeavePatience);
}

bridges::FeedOptions Publisher::feed_options() const {
  bridges::FeedOptions options;
  options.socket = settings_.socket;
  options.max_rate_hz = feed_rate_hz();
  options.max_age_s = settings_.max_age_s;
  options.texts = true;
  options.patience_s = [this] { return patience_s(); };
  return options;
}

std::chrono::nanoseconds Publisher::silence() const {
  const std::chrono::duration<double> age(settings_.max_age_s);
  return std::max<std::chrono::nanoseconds>(kLeastSilence,
                                            std::chrono::duration_cast<std::chrono::nanoseconds>(age));
}

// Of a sensor; rate_hz is that of its messages.
double Publisher::feed_rate_hz() const {
  return std::max(settings_.rate_hz, kEstimatesPerSilence / std::chrono::duration<double>(silence()).count());
}

// A slipd that hangs must not keep this program from saying so in time.
double Publisher::patience_s() const {
  const std::chrono::duration<double> left = states_.next_stale() - Clock::now();
  return std::clamp(left.count(), kLeastPatience, kLongestPatience);
}

bridges::FeedListener Publisher::feed_listener() {
  bridges::FeedListener listener;
  listener.serves = [this](const bridges::Inventory& inventory) { note_serving(inventory); };
  listener.away = [this](std::string_view why) { note_away(why); };
  listener.estimate = [this](const slipd_estimate& estimate, std::string_view text) { take(estimate, text); };
  return listener;
}

void Publisher::take(const slipd_estimate& estimate, std::string_view text) {
  slipd_estimate now = estimate;
  const int stood = states_.standing_alert(now.name);
  states_.take(now, std::string(text), Clock::now());
  note_margin(now);
  take_alert(now, stood, text);
  if (now.event == SLIPD_EVENT_ESTIMATE) put_estimate(now, text);
  want_grasps(now);
  send();
}

void Publisher::note_margin(const slipd_estimate& estimate) {
  const double gamma = slipd_margin(&estimate);
  if (std::isnan(gamma)) return;
  const auto [least, first] = least_.emplace(estimate.name, gamma);
  if (!first) least->second = std::min(least->second, gamma);
}

// At most rate_hz of a name, where slipd sends more so that its silence is noticed.
void Publisher::put_estimate(const slipd_estimate& estimate, std::string_view text) {
  const auto now = Clock::now();
  if (settings_.rate_hz < feed_rate_hz()) {
    auto& due = estimate_due_[estimate.name];
    if (now < due) return;
    const auto period =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / settings_.rate_hz));
    due = std::max(due + period, now);
  }
  const std::chrono::duration<double> age(std::isfinite(estimate.age_s) ? estimate.age_s : 0);
  const std::chrono::duration<double> holds(settings_.max_age_s);
  const auto left = std::chrono::duration_cast<Clock::duration>(age <= holds ? holds - age : holds);
  put(topic_of(estimate.name, "estimate"),
      {estimate_message(estimate, text), false, now + left, in_seconds(left)});
}

// A grasp changes with each of its sensors. Its estimates follow those of the sensor that it names last.
void Publisher::want_grasps(const slipd_estimate& estimate) {
  if (!slipd_) return;
  for (const auto& grasp : slipd_->grasps) {
    if (std::find(grasp.sensors.begin(), grasp.sensors.end(), estimate.name) == grasp.sensors.end()) continue;
    const bool is_estimate = estimate.event == SLIPD_EVENT_ESTIMATE;
    if (is_estimate && grasp.sensors.back() != estimate.name) continue;
    want_grasp_estimates_ = want_grasp_estimates_ || is_estimate;
    if (!asking_.running())
      asking_.start(std::max(Clock::duration(0), grasps_asked_at_ + kGraspPause - Clock::now()));
  }
}

void Publisher::ask_grasps() {
  grasps_asked_at_ = Clock::now();
  char* text = nullptr;
  // If it fails, the feed finds and says that slipd is away.
  if (slipd_call(feed_.client(), "gamma", nullptr, -1, patience_s(), &text) != SLIPD_DONE) return;
  const std::unique_ptr<char, void (*)(char*)> owned(text, slipd_free);
  for (const GraspEstimate& grasp : grasps_of(text, settings_.max_age_s, bridges::monotonic_ns()))
    take_grasp(grasp);
  want_grasp_estimates_ = false;
  send();
}

void Publisher::take_grasp(const GraspEstimate& grasp) {
  slipd_estimate now = grasp.estimate;
  if (!serves(now.name) || slipd_->has_sensor(now.name)) return;
  const int stood = states_.standing_alert(now.name);
  const bool changed = states_.take(now, grasp.text, Clock::now());
  note_margin(now);
  take_alert(now, stood, grasp.text);
  if (changed || want_grasp_estimates_) put_estimate(now, grasp.text);
}

bool Publisher::serves(const std::string& name) const {
  return slipd_ && slipd_->has(name);
}

// Whichever event brought it: the event of an alert may be lost, and slipd sends the estimate before it.
void Publisher::take_alert(const slipd_estimate& estimate, int stood, std::string_view text) {
  if (estimate.alert == stood || estimate.alert == SLIPD_ALERT_UNKNOWN) return;
  const auto payload = [&](std::int64_t number, std::int64_t dropped) {
    return alert_message(text, store_.series(), number, dropped);
  };
  store_.append(topic_of(estimate.name, "alert"), payload,
                estimate.alert == SLIPD_ALERT_NONE ? 0 : realtime_ns(), estimate.alert);
  if (!summary_is_near_) summary_.start(std::min<Clock::duration>(kSummaryAfterAlert, settings_.summary));
  summary_is_near_ = true;
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
  for (const auto& grasp : inventory.grasps) {
    if (inventory.has_sensor(grasp.name))
      log(LogLevel::error, "the grasp " + grasp.name + " has no topics: a sensor has its name; rename one");
  }
  for (const std::string& name : states_.forget([&](const std::string& each) { return !serves(each); }))
    put_retained(topic_of(name, "state"), "");  // the broker forgets the topic
  put_status();
  send();
}

void Publisher::note_away(std::string_view why) {
  log(LogLevel::warning, why);
  lose_states();
  slipd_.reset();
  trouble_ = why;
  put_status();
  send();
}

// Nobody watches any more. An alert that was raised stands.
void Publisher::lose_states() {
  if (!slipd_) return;
  for (const auto& sensor : slipd_->sensors) states_.lose(sensor.name, away_text(sensor.name, realtime_ns()));
  for (const auto& grasp : slipd_->grasps)
    if (!slipd_->has_sensor(grasp.name)) states_.lose(grasp.name, away_text(grasp, realtime_ns()));
}

void Publisher::say_states() {
  states_.say_due(Clock::now(), [this](const States::State& state) {
    put_retained(topic_of(state.estimate.name, "state"),
                 state_message(state.estimate, state.text, valid_for()));
  });
  if (const auto next = states_.next(); next != States::Time::max())
    saying_.start(std::max(Clock::duration(0), next - Clock::now()));
}

// The one after that at which this program ended without meaning to: a start at it would end the same way.
std::size_t Publisher::first_broker() const {
  if (!tried_.left_behind()) return 0;
  const auto& brokers = settings_.brokers;
  const auto left = std::find_if(brokers.begin(), brokers.end(), [&](const BrokerSettings& broker) {
    return broker.name() == *tried_.left_behind();
  });
  if (left == brokers.end()) return 0;
  const std::size_t next = (static_cast<std::size_t>(left - brokers.begin()) + 1) % brokers.size();
  log(LogLevel::warning, left->name() + ": slipd-mqtt ended while it was there" +
                             (brokers.size() > 1 ? "; " + brokers[next].name() + " has its turn" : ""));
  return next;
}

void Publisher::connect() {
  const BrokerSettings& next = settings_.brokers[turns_.current()];
  tried_.note(next.name());
  BrokerListener listener;
  listener.accepted = [this] { note_accepted(); };
  listener.acknowledged = [this](int message) { note_acknowledged(message); };
  listener.writable = [this] { send(); };
  listener.lost = [this](const std::string& why) { note_lost(why); };
  const LastWill will{host_topic("status"), offline_message(0)};
  broker_ = std::make_unique<Broker>(loop_, next, settings_.topic_prefix + "-" + settings_.host, mqtt_, will,
                                     listener);
}

// All retained topics are published anew: the broker may be another one.
void Publisher::note_accepted() {
  const BrokerSettings& broker = settings_.brokers[turns_.current()];
  log(LogLevel::info, broker.name() + ": accepted, " + std::to_string(store_.waiting()) + " alerts wait" +
                          (mqtt_ == MqttVersion::v5 ? "" : "; MQTT 3.1.1, so retained topics do not expire"));
  store_.flush();
  on_their_way_.clear();
  sent_ = 0;
  progress_at_ = Clock::now();
  states_.renew();
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
  const auto held = broker_->held();
  const bool older = broker_->refuses_version();
  if (!older) log(LogLevel::warning, why);
  broker_.reset();
  on_their_way_.clear();
  mqtt_ = older ? MqttVersion::v3_1_1 : MqttVersion::v5;
  if (older) return connecting_.start({});
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
  put(topic, {std::move(payload), true, Clock::time_point::max(), in_seconds(valid_for())});
}

void Publisher::put_status() {
  put_retained(host_topic("status"), online_message(gripper(), realtime_ns()));
}

void Publisher::put_summary() {
  summary_.start(settings_.summary);
  summary_is_near_ = false;
  Summary summary;
  if (slipd_) {
    for (const auto& [name, state] : states_.all())
      (slipd_->has_sensor(name) ? summary.sensors : summary.grasps)[name] = summary_line(state.estimate);
  }
  least_.clear();
  summary.alerts_last_hour = store_.last_hour(realtime_ns());
  summary.period_s = std::chrono::duration<double>(settings_.summary).count();
  put_retained(host_topic("summary"), summary_message(gripper(), summary, realtime_ns()));
  put_status();
  put(host_topic("seen"), {seen_message(gripper(), realtime_ns()), true});
  send();
}

SummaryLine Publisher::summary_line(const slipd_estimate& estimate) const {
  SummaryLine line;
  line.gamma = slipd_margin(&estimate);
  const bool young = estimate.state != SLIPD_STATE_OK || !std::isnan(line.gamma);
  line.state = slipd_state_name(young ? estimate.state : int{SLIPD_STATE_STALE});
  line.alert = slipd_alert_name(estimate.alert);
  if (const auto least = least_.find(estimate.name); least != least_.end()) line.gamma_min = least->second;
  return line;
}

// Alerts first. The rest while the broker takes it: what it does not take stays in its place.
void Publisher::send() {
  say_states();
  send_alerts();
  while (!pending_.empty() && broker_ && broker_->writable()) {
    const auto next = pending_.extract(pending_.begin());
    const Pending& message = next.mapped();
    if (Clock::now() <= message.expires)
      broker_->publish(next.key(), message.payload, 0, message.retain, message.broker_keeps);
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
  return {version_,
          slipd_,
          {store_.series(), store_.last(), store_.waiting(), store_.dropped()},
          trouble_,
          valid_for()};
}

}  // namespace slipd::mqtt
