#include "bridges/ros2/subjects.hpp"

#include <algorithm>

#include "bridges/ros2/diagnostics.hpp"
#include "bridges/ros2/messages/sensor_messages.hpp"

namespace slipd::ros2 {
namespace {

constexpr std::chrono::nanoseconds kShortestBeat = std::chrono::milliseconds(100);

}  // namespace

std::chrono::nanoseconds Subjects::beat(double max_age_s) {
  return std::max(kShortestBeat, std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * max_age_s)));
}

Subjects::Subjects(Node& node, Recorder& recorder, std::chrono::nanoseconds beat)
    : node_(node),
      recorder_(recorder),
      beat_ns_(beat.count()),
      watcher_([this](const std::stop_token& stop) { watch(stop); }) {}

Subjects::~Subjects() {
  watcher_ = {};
  clear();
}

bool Subjects::add(const SubjectOptions& options, std::string& other) {
  const std::lock_guard lock(mutex_);
  const auto topic = [&](std::string_view name, const char* leaf) {
    return topic_of(options.prefix, name, leaf);
  };
  const std::string margin = topic(options.name, "margin");
  const auto same = std::find_if(subjects_.begin(), subjects_.end(),
                                 [&](const auto& named) { return topic(named.first, "margin") == margin; });
  if (same != subjects_.end()) {
    other = same->first;
    return false;
  }
  Subject& subject = subjects_[options.name];
  subject.last.name = options.name;
  subject.last.header.frame_id = options.frame_id;
  subject.hardware = options.hardware;
  const auto open = [&](auto& output, const char* leaf) {
    const TopicOptions of_topic = options.topic(leaf);
    if (of_topic.publish) output.emplace(node_, recorder_, topic(options.name, leaf), of_topic);
  };
  open(subject.wrench, "wrench");
  open(subject.margin, "margin");
  open(subject.margin_low, "margin_low");
  open(subject.estimate, "estimate");
  open(subject.alert, "alert");
  return true;
}

void Subjects::clear() {
  const std::lock_guard lock(mutex_);
  connected_ = false;
  end_all();
  subjects_.clear();
}

void Subjects::set_connected(bool connected) {
  const std::lock_guard lock(mutex_);
  connected_ = connected;
  if (!connected) end_all();
}

void Subjects::take(const slipd_estimate& estimate) {
  const Moment now = Moment::now();
  const std::lock_guard lock(mutex_);
  const auto found = subjects_.find(std::string_view(estimate.name));
  if (found == subjects_.end()) return;
  Subject& subject = found->second;
  sooner_ = sooner_ || subject.fresh_until_ns == 0;
  if (sooner_) look_.notify_one();
  fill_message(estimate, now, subject.last);
  if (estimate.time_ns != 0)
    subject.last.header.stamp =
        time_of(subject.stamps.of(estimate.sequence, realtime_of_sample(estimate, now)));
  subject.fresh_until_ns = estimate.valid_until_ns;
  subject.dropped += estimate.dropped;
  // The estimate of an alert comes by itself, too.
  if (estimate.event != SLIPD_EVENT_ALERT) publish(subject, now);
  publish_alert(subject, now);
}

std::int64_t Subjects::stamp_of(std::string_view name, std::uint64_t seq, std::int64_t realtime_ns) {
  const std::lock_guard lock(mutex_);
  const auto found = subjects_.find(name);
  return found == subjects_.end() ? realtime_ns : found->second.stamps.of(seq, realtime_ns);
}

bool Subjects::wanted() const {
  const std::lock_guard lock(mutex_);
  const auto is_wanted = [](const auto& output) { return output && output->wanted(); };
  return std::any_of(subjects_.begin(), subjects_.end(), [&](const auto& named) {
    const Subject& subject = named.second;
    return is_wanted(subject.wrench) || is_wanted(subject.margin) || is_wanted(subject.margin_low) ||
           is_wanted(subject.estimate);
  });
}

std::vector<DiagnosticStatus> Subjects::diagnostics(double seconds) {
  const std::lock_guard lock(mutex_);
  std::vector<DiagnosticStatus> all;
  for (auto& [name, subject] : subjects_) {
    const SlipEstimate& last = subject.last;
    // Frames of the sensor a second, of a grasp those of all its sensors.
    std::optional<double> rate_hz;
    if (seconds > 0 && subject.reported && last.seq >= *subject.reported)  // less: slipd began anew
      rate_hz = static_cast<double>(last.seq - *subject.reported) / seconds;
    all.push_back(status_of(last, subject.hardware, rate_hz, subject.dropped));
    subject.reported = last.seq;
  }
  return all;
}

// What has changed is published at any rate.
void Subjects::publish(Subject& subject, const Moment& now) {
  const SlipEstimate& last = subject.last;
  const bool news = last.state != subject.told_state || last.alert != subject.told_alert;
  const auto put = [&](auto& output, const auto& make) {
    if (!output) return;
    if (news) {
      output->put_now(now, make);
    } else {
      output->put(now, make);
    }
  };
  subject.told_state = last.state;
  subject.told_alert = last.alert;
  subject.published_ns = now.monotonic_ns;
  put(subject.margin, [&] { return margin_of(last); });
  put(subject.wrench, [&] { return wrench_of(last); });
  put(subject.margin_low, [&] { return margin_low_of(last); });
  put(subject.estimate, [&]() -> const SlipEstimate& { return last; });
}

void Subjects::publish_alert(Subject& subject, const Moment& now) {
  if (subject.last.alert == subject.alert_news) return;
  subject.alert_news = subject.last.alert;
  if (subject.alert) subject.alert->put_now(now, [&]() -> const SlipEstimate& { return subject.last; });
}

// There is no present estimate. A fault stands: slipd says it once.
void Subjects::end_estimate(Subject& subject, const Moment& now) const {
  const bool fault = subject.last.state == SlipEstimate::kFault;
  subject.fresh_until_ns = 0;
  clear_message(!connected_ ? SlipEstimate::kDisconnected
                : fault     ? SlipEstimate::kFault
                            : SlipEstimate::kStale,
                now, subject.last);
  publish(subject, now);
  publish_alert(subject, now);
}

void Subjects::end_all() {
  const Moment now = Moment::now();
  for (auto& [name, subject] : subjects_) end_estimate(subject, now);
}

// Publishes what is due; when to look again, CLOCK_MONOTONIC.
std::int64_t Subjects::tend(Subject& subject, const Moment& now) const {
  if (subject.fresh_until_ns >= now.monotonic_ns) return subject.fresh_until_ns + 1;
  if (subject.fresh_until_ns != 0 || now.monotonic_ns - subject.published_ns >= beat_ns_)
    end_estimate(subject, now);
  return subject.published_ns + beat_ns_;
}

// The thread. A writer of alerts, which are rare, says with each beat that it lives.
void Subjects::watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  std::int64_t asserted_ns = 0;
  while (!stop.stop_requested()) {
    sooner_ = false;
    const Moment now = Moment::now();
    const bool asserts = now.monotonic_ns - asserted_ns >= beat_ns_;
    if (asserts) asserted_ns = now.monotonic_ns;
    std::int64_t due_ns = asserted_ns + beat_ns_;
    for (auto& [name, subject] : subjects_) {
      due_ns = std::min(due_ns, tend(subject, now));
      if (asserts && subject.alert) subject.alert->assert_alive();
    }
    const std::chrono::steady_clock::time_point due{std::chrono::nanoseconds(due_ns)};
    look_.wait_until(lock, stop, due, [&] { return sooner_; });
  }
}

}  // namespace slipd::ros2
