#include "bridges/ros2/bridge.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "bridges/ros2/dds/node_settings.hpp"
#include "bridges/ros2/messages/sensor_messages.hpp"
#include "bridges/support/log.hpp"

namespace slipd::ros2 {
namespace {

constexpr double kUsualTaxelRate = 10, kUsualReportRate = 1;  // Hz
constexpr double kNsPerS = 1e9;
// Estimates within max_age_ms while no topic of estimates has a reader: enough to see that slipd is silent.
constexpr double kIdleEstimates = 4;
// How long slipd may take to pass its shared memory, s.
constexpr double kAttach = 1;
// Beats of Subjects within the deadline that topics offer: a beat may be late by one.
constexpr int kBeatsOffered = 2;
// Deadlines within the liveliness lease. A reader counts no deadlines of a writer that it takes for dead, so
// the first miss must come before.
constexpr int kDeadlinesOfALease = 2;

std::chrono::nanoseconds seconds(double s) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(kNsPerS * s));
}

}  // namespace

Ros2Bridge::Ros2Bridge(const nlohmann::json& settings, bridges::Loop& loop)
    : settings_(settings),
      max_age_s_(1e-3 * settings.at("max_age_ms").get<double>()),
      recorder_(settings.at("record")),
      node_(node_options(settings), [this] { readers_changed_.ring(); }),
      subjects_(node_, recorder_, Subjects::beat(max_age_s_)),
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
      host_(loop, node_options(settings)) {
  const TopicOptions diagnostics = topic_options("diagnostics");
  if (diagnostics.publish)
    diagnostics_.emplace(node_, recorder_, "/diagnostics", TopicOptions{.writer = diagnostics.writer});
  node_.announce();
  if (diagnostics_) report_.start({});
}

TopicOptions Ros2Bridge::topic_options(const char* topic) const {
  const nlohmann::json& options = settings_.at("topics").at(topic);
  return {.publish = options.at("publish"),
          .rate_hz = options.at("rate_hz"),
          .writer = {.depth = options.at("depth"), .reliable = options.at("reliable")}};
}

void Ros2Bridge::serve(const bridges::Inventory& inventory) {
  // Topics of a slipd that has the same sensors as before go on, so that readers keep them.
  if (taxels_ == nullptr || inventory.sensors != served_.sensors || inventory.grasps != served_.grasps)
    open_topics(inventory);
  served_ = inventory;
  subjects_.set_connected(true);
  attach();
  bridges::log(bridges::LogLevel::notice, "slipd " + inventory.version + ": " +
                                              std::to_string(inventory.sensors.size()) + " sensors and " +
                                              std::to_string(inventory.grasps.size()) + " grasps on topics " +
                                              settings_.at("prefix").get<std::string>() + "/…");
}

void Ros2Bridge::open_topics(const bridges::Inventory& inventory) {
  taxels_.reset();
  subjects_.clear();
  grasps_.clear();
  std::vector<TaxelSource> sources;
  for (const auto& sensor : inventory.sensors) add_subject(sensor.name, sensor.driver, &sources);
  for (const auto& grasp : inventory.grasps) {
    if (inventory.has_sensor(grasp.name)) continue;  // a sensor of the same name
    add_subject(grasp.name, "grasp", nullptr);
    // Its estimate changes with that of each sensor; the last one's is the newest.
    if (!grasp.sensors.empty()) grasps_[grasp.sensors.back()].push_back(grasp.name);
  }
  const double rate_hz = topic_options("taxels").rate_hz;
  taxels_ = std::make_unique<TaxelLane>(
      settings_.at("socket"), rate_hz > 0 ? rate_hz : kUsualTaxelRate, std::move(sources),
      [this](std::string_view sensor, std::uint64_t seq, std::int64_t realtime_ns) {
        return subjects_.stamp_of(sensor, seq, realtime_ns);
      });
  node_.announce();
  readers_changed_.ring();
}

// `taxels`: of a sensor, where the source of its taxels goes.
void Ros2Bridge::add_subject(const std::string& name, const std::string& hardware,
                             std::vector<TaxelSource>* taxels) {
  const std::string prefix = settings_.at("prefix");
  const std::string frame_id = settings_.at("frames").value(name, name);
  const auto period = [](double rate_hz) { return seconds(rate_hz > 0 ? 1 / rate_hz : 0); };
  const auto topic = [&](const char* leaf) {
    TopicOptions options = topic_options(leaf);
    WriterOptions& writer = options.writer;
    const bool rare = std::string_view(leaf) == "alert";
    const auto beats = kBeatsOffered * Subjects::beat(max_age_s_);
    const auto deadline = rare ? beats : beats + period(options.rate_hz);
    if (!rare) writer.deadline = deadline;
    // That the writer of rare messages lives goes to reliable readers only.
    if (!rare || writer.reliable) writer.lease = kDeadlinesOfALease * deadline;
    return options;
  };
  std::string other;
  if (!subjects_.add({name, frame_id, hardware, prefix, topic}, other)) {
    bridges::log(bridges::LogLevel::error,
                 name + " has no topics: in ROS its name is that of " + other + "; rename one of them");
    return;
  }
  const TopicOptions options = topic_options("taxels");
  if (taxels == nullptr || !options.publish) return;
  auto output = std::make_unique<Output<PointCloud2>>(node_, recorder_, topic_of(prefix, name, "taxels"),
                                                      TopicOptions{.writer = options.writer});
  taxels->push_back({name, frame_id, std::move(output), {}});
}

// Grasps are read from the shared memory.
void Ros2Bridge::attach() {
  attached_ = !grasps_.empty() && slipd_attach(feed_.client(), nullptr, kAttach) == SLIPD_DONE;
}

void Ros2Bridge::go_away(std::string_view why) {
  bridges::log(bridges::LogLevel::warning, why);
  attached_ = false;
  subjects_.set_connected(false);
}

// A topic has got or lost a reader. Alerts come at any rate.
void Ros2Bridge::choose_rate() {
  readers_changed_.hear();
  feed_.limit_rate(subjects_.wanted() ? 0 : kIdleEstimates / max_age_s_);
}

void Ros2Bridge::take(const slipd_estimate& estimate) {
  subjects_.take(estimate);
  if (estimate.event == SLIPD_EVENT_ALERT) return;
  const auto grasps = grasps_.find(std::string_view(estimate.name));
  if (grasps == grasps_.end()) return;
  for (const std::string& name : grasps->second) {
    slipd_estimate grasp;
    if (attached_ && slipd_latest(feed_.client(), name.c_str(), max_age_s_, &grasp) == SLIPD_DONE) {
      subjects_.take(grasp);
    } else {
      attach();  // after a restart or reload; at most once for each estimate of a sensor
    }
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
  all.status = subjects_.diagnostics(passed);
  if (all.status.empty()) {
    DiagnosticStatus& none = all.status.emplace_back();
    none.level.value = DiagnosticStatus::kError;
    none.name = "slipd";
    none.message = "slipd does not answer on " + settings_.at("socket").get<std::string>();
  }
  diagnostics_->put_now(now, [&]() -> const DiagnosticArray& { return all; });
}

}  // namespace slipd::ros2
