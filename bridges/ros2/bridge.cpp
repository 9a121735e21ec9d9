#include "bridges/ros2/bridge.hpp"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <utility>

#include "bridges/ros2/messages/sensor_messages.hpp"
#include "bridges/support/log.hpp"

namespace slipd::ros2 {
namespace {

constexpr double kUsualTaxelRate = 10, kUsualReportRate = 1;  // Hz
constexpr double kNsPerS = 1e9;
// While slipd is away or silent, messages without numbers come this often.
constexpr std::int64_t kSilentPeriodNs = 1'000'000'000;
// Estimates within max_age_ms while no topic of estimates has a reader: enough to see that slipd is silent.
constexpr double kIdleEstimates = 4;
// How long slipd may take to pass its shared memory, s.
constexpr double kAttach = 1;

NodeOptions node_options(const nlohmann::json& settings) {
  const nlohmann::json& network = settings.at("network");
  return {.domain = settings.at("domain"),
          .interfaces = network.at("interfaces"),
          .multicast = network.at("multicast"),
          .peers = network.at("peers"),
          .name = settings.at("node"),
          .name_space = "/",
          .humble = settings.at("distribution") == "humble"};
}

std::chrono::nanoseconds seconds(double s) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(kNsPerS * s));
}

std::string text_of(double value) {
  return nlohmann::json(value).dump();
}

}  // namespace

std::vector<Problem> check_settings(const nlohmann::json& settings) {
  std::vector<Problem> problems;
  const nlohmann::json& network = settings.at("network");
  const nlohmann::json& interfaces = network.at("interfaces");
  for (const char* const name : {"lo", kHost}) {
    if (interfaces.size() > 1 && std::find(interfaces.begin(), interfaces.end(), name) != interfaces.end())
      problems.push_back(problem_of("/network/interfaces", interfaces,
                                    std::string(name) +
                                        " beside others: name the others only, as nodes of this computer use "
                                        "them, too"));
  }
  if (!network.at("multicast").get<bool>() && network.at("peers").empty())
    problems.push_back(problem_of("/network/peers", network.at("peers"),
                                  "no peers and no multicast: no node could be found; give one of them"));
  return problems;
}

Ros2Bridge::Ros2Bridge(const nlohmann::json& settings, bridges::Loop& loop)
    : settings_(settings),
      max_age_s_(1e-3 * settings.at("max_age_ms").get<double>()),
      recorder_(settings.at("record")),
      node_(node_options(settings), [this] { readers_changed_.ring(); }),
      silence_(loop, [this] { watch_silence(); }),
      report_(loop, [this] { report(); }),
      feed_(loop,
            {.socket = settings.at("socket"),
             .events = SLIPD_EVENT_ESTIMATE | SLIPD_EVENT_ALERT,
             .max_rate_hz = kIdleEstimates / max_age_s_,
             .max_age_s = max_age_s_},
            {.serves = [this](const bridges::Inventory& inventory) { serve(inventory); },
             .away = [this](std::string_view why) { go_away(why); },
             .estimate = [this](const slipd_estimate& estimate, std::string_view) { take(estimate); }}),
      readers_(loop, readers_changed_.fd(), EPOLLIN, [this](std::uint32_t) { choose_rate(); }),
      host_(host_interfaces()),
      addresses_(loop, changes_.fd(), EPOLLIN, [this](std::uint32_t) { note_addresses(); }) {
  const TopicOptions diagnostics = topic_options("diagnostics");
  if (diagnostics.publish)
    diagnostics_.emplace(node_, recorder_, "/diagnostics", TopicOptions{.writer = diagnostics.writer});
  node_.announce();
  silence_.start(seconds(max_age_s_));
  if (diagnostics_) report_.start({});
}

TopicOptions Ros2Bridge::topic_options(const char* topic) const {
  const nlohmann::json& options = settings_.at("topics").at(topic);
  return {.publish = options.at("publish"),
          .rate_hz = options.at("rate_hz"),
          .writer = {.depth = options.at("depth"), .reliable = options.at("reliable")}};
}

void Ros2Bridge::serve(const bridges::Inventory& inventory) {
  taxels_.reset();
  subjects_.clear();
  std::vector<TaxelSource> sources;
  for (const auto& sensor : inventory.sensors) add_subject(sensor.name, sensor.driver, true, sources);
  for (const auto& grasp : inventory.grasps) {
    if (subjects_.contains(grasp.name)) continue;  // a sensor of the same name
    add_subject(grasp.name, "grasp", false, sources);
    // Its estimate changes with that of each sensor; the last one's is the newest.
    const auto sensor = grasp.sensors.empty() ? subjects_.end() : subjects_.find(grasp.sensors.back());
    if (sensor != subjects_.end()) sensor->second.grasps.push_back(grasp.name);
  }
  attached_ = !inventory.grasps.empty() && slipd_attach(feed_.client(), nullptr, kAttach) == SLIPD_DONE;
  const TopicOptions taxels = topic_options("taxels");
  if (!sources.empty()) {
    taxels_ = std::make_unique<TaxelLane>(
        settings_.at("socket"), taxels.rate_hz > 0 ? taxels.rate_hz : kUsualTaxelRate, std::move(sources));
  }
  node_.announce();
  readers_changed_.ring();
  bridges::log(bridges::LogLevel::notice, "slipd " + inventory.version + ": " +
                                              std::to_string(inventory.sensors.size()) + " sensors and " +
                                              std::to_string(inventory.grasps.size()) + " grasps on topics " +
                                              settings_.at("prefix").get<std::string>() + "/…");
}

void Ros2Bridge::add_subject(const std::string& name, const std::string& hardware, bool sensor,
                             std::vector<TaxelSource>& taxels) {
  const std::string prefix = settings_.at("prefix");
  const std::string margin = topic_of(prefix, name, "margin");
  for (const auto& [other, subject] : subjects_) {
    if (topic_of(prefix, other, "margin") != margin) continue;
    bridges::log(bridges::LogLevel::error, std::string(name)
                                               .append(" has no topics: in ROS its name is that of ")
                                               .append(other)
                                               .append("; rename one of them"));
    return;
  }
  Subject& subject = subjects_[name];
  subject.last.name = name;
  subject.last.header.frame_id = settings_.at("frames").value(name, name);
  subject.hardware = hardware;
  const auto open = [&](auto& output, const char* topic) {
    const TopicOptions options = topic_options(topic);
    if (options.publish) output.emplace(node_, recorder_, topic_of(prefix, name, topic), options);
  };
  open(subject.wrench, "wrench");
  open(subject.margin, "margin");
  open(subject.margin_low, "margin_low");
  open(subject.estimate, "estimate");
  open(subject.alert, "alert");
  const TopicOptions options = topic_options("taxels");
  if (sensor && options.publish) {
    auto output = std::make_unique<Output<PointCloud2>>(node_, recorder_, topic_of(prefix, name, "taxels"),
                                                        TopicOptions{.writer = options.writer});
    taxels.push_back({name, subject.last.header.frame_id, std::move(output)});
  }
}

void Ros2Bridge::go_away(std::string_view why) {
  bridges::log(bridges::LogLevel::warning, why);
  const Moment now = Moment::now();
  attached_ = false;
  for (auto& [name, subject] : subjects_) {
    subject.taken_ns = 0;
    clear_message(SlipEstimate::kDisconnected, now, subject.last);
    publish(subject, now, true);
  }
}

bool Ros2Bridge::estimates_wanted() const {
  const auto wanted = [](const auto& output) { return output && output->wanted(); };
  return std::any_of(subjects_.begin(), subjects_.end(), [&](const auto& named) {
    const Subject& subject = named.second;
    return wanted(subject.wrench) || wanted(subject.margin) || wanted(subject.margin_low) ||
           wanted(subject.estimate);
  });
}

// A topic has got or lost a reader. Alerts come at any rate.
void Ros2Bridge::choose_rate() {
  readers_changed_.hear();
  feed_.limit_rate(estimates_wanted() ? 0 : kIdleEstimates / max_age_s_);
}

// Nodes that start from now on give the new addresses, which Cyclone DDS uses from the next start on.
void Ros2Bridge::note_addresses() {
  changes_.take();
  if (settings_.at("network").at("interfaces") != nlohmann::json::array({kHost}) ||
      host_interfaces() == host_)
    return;
  bridges::log(bridges::LogLevel::notice, "this computer's addresses have changed: the node starts anew");
  kill(getpid(), SIGHUP);
}

void Ros2Bridge::take(const slipd_estimate& estimate) {
  const auto found = subjects_.find(std::string_view(estimate.name));
  if (found == subjects_.end()) return;
  Subject& subject = found->second;
  const Moment now = Moment::now();
  subject.dropped += estimate.dropped;
  if (estimate.event == SLIPD_EVENT_ALERT) {  // the same estimate comes by itself
    SlipEstimate message = subject.last;
    fill_message(estimate, now, message);
    publish_alert(subject, message, now);
    return;
  }
  const std::uint8_t alert = subject.last.alert;
  const std::uint8_t state = subject.last.state;
  fill_message(estimate, now, subject.last);
  subject.sequence = estimate.sequence;
  subject.taken_ns = now.monotonic_ns;
  publish(subject, now, subject.last.state != state || subject.last.alert != alert);
  if (!subject.grasps.empty()) take_grasps(subject.grasps);
}

void Ros2Bridge::take_grasps(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    slipd_estimate estimate;
    if (!attached_ || slipd_latest(feed_.client(), name.c_str(), max_age_s_, &estimate) != SLIPD_DONE) {
      // After a restart or reload; at most once for each estimate of a sensor.
      attached_ = slipd_attach(feed_.client(), nullptr, kAttach) == SLIPD_DONE;
      continue;
    }
    Subject& grasp = subjects_.at(name);
    const Moment now = Moment::now();
    const bool news = estimate.alert != grasp.last.alert;
    const bool changed = news || estimate.state != grasp.last.state;
    fill_message(estimate, now, grasp.last);
    grasp.sequence = estimate.sequence;
    grasp.taken_ns = now.monotonic_ns;
    publish(grasp, now, changed);
    if (news) publish_alert(grasp, grasp.last, now);
  }
}

void Ros2Bridge::publish(Subject& subject, const Moment& now, bool at_any_rate) {
  const SlipEstimate& last = subject.last;
  const auto put = [&](auto& output, const auto& make) {
    if (!output) return;
    if (at_any_rate) {
      output->put_now(now, make);
    } else {
      output->put(now, make);
    }
  };
  subject.published_ns = now.monotonic_ns;
  put(subject.margin, [&] { return margin_of(last); });
  put(subject.wrench, [&] { return wrench_of(last); });
  put(subject.margin_low, [&] { return margin_low_of(last); });
  put(subject.estimate, [&]() -> const SlipEstimate& { return last; });
}

void Ros2Bridge::publish_alert(Subject& subject, const SlipEstimate& message, const Moment& now) {
  if (subject.alert) subject.alert->put_now(now, [&]() -> const SlipEstimate& { return message; });
}

// The timer: a slipd that sends nothing, though it is connected, has stopped or hangs.
void Ros2Bridge::watch_silence() {
  silence_.start(seconds(max_age_s_));
  const Moment now = Moment::now();
  for (auto& [name, subject] : subjects_) {
    const bool was_taken = subject.taken_ns != 0;
    const bool silent =
        !was_taken || static_cast<double>(now.monotonic_ns - subject.taken_ns) > kNsPerS * max_age_s_;
    if (!silent || (!was_taken && now.monotonic_ns - subject.published_ns < kSilentPeriodNs)) continue;
    subject.taken_ns = 0;
    clear_message(feed_.connected() ? SlipEstimate::kStale : SlipEstimate::kDisconnected, now, subject.last);
    publish(subject, now, true);
  }
}

void Ros2Bridge::report() {
  const double rate = topic_options("diagnostics").rate_hz;
  report_.start(seconds(1 / (rate > 0 ? rate : kUsualReportRate)));
  const Moment now = Moment::now();
  const double passed =
      reported_ns_ == 0 ? 0 : static_cast<double>(now.monotonic_ns - reported_ns_) / kNsPerS;
  reported_ns_ = now.monotonic_ns;
  DiagnosticArray all;
  all.header.stamp = time_of(now.realtime_ns);
  if (subjects_.empty()) {
    DiagnosticStatus& none = all.status.emplace_back();
    none.level.value = DiagnosticStatus::kError;
    none.name = "slipd";
    none.message = "slipd does not answer on " + settings_.at("socket").get<std::string>();
  }
  for (auto& [name, subject] : subjects_) {
    all.status.push_back(status_of(subject, passed));
    if (subject.taken_ns != 0) subject.reported = subject.sequence;
  }
  diagnostics_->put_now(now, [&]() -> const DiagnosticArray& { return all; });
}

// Frames of the sensor a second, of a grasp those of all its sensors; empty if unknown, as after a restart of
// slipd.
std::string Ros2Bridge::text_of_rate(const Subject& subject, double seconds) {
  if (!(seconds > 0) || !subject.reported || subject.sequence < *subject.reported) return "";
  return text_of(static_cast<double>(subject.sequence - *subject.reported) / seconds);
}

DiagnosticStatus Ros2Bridge::status_of(const Subject& subject, double seconds) const {
  const SlipEstimate& last = subject.last;
  DiagnosticStatus status;
  const bool fine = last.state == SlipEstimate::kOk || last.state == SlipEstimate::kNoContact;
  status.level.value = fine                                 ? DiagnosticStatus::kOk
                       : last.state == SlipEstimate::kStale ? DiagnosticStatus::kStale
                       : last.state >= SlipEstimate::kFault ? DiagnosticStatus::kError
                                                            : DiagnosticStatus::kWarn;
  status.name = "slipd: " + last.name;
  status.message = slipd_state_name(last.state);
  status.hardware_id = subject.hardware;
  status.values = {{.key = "state", .value = slipd_state_name(last.state)},
                   {.key = "alert", .value = slipd_alert_name(last.alert)},
                   {.key = "rate_hz", .value = text_of_rate(subject, seconds)},
                   {.key = "age_s", .value = std::isfinite(last.age) ? text_of(last.age) : ""},
                   {.key = "dropped", .value = std::to_string(subject.dropped)},
                   {.key = "simulated", .value = last.simulated ? "true" : "false"}};
  return status;
}

}  // namespace slipd::ros2
