#include "daemon/rpc/methods/status.hpp"

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "daemon/board/as_of.hpp"
#include "daemon/can/dbc.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/rt/clock.hpp"
#include "daemon/telemetry/frame_health_monitor.hpp"
#include "drivers/can/can_interface.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

// 0: the method has no such setting.
json setting(int value) {
  return value > 0 ? json(value) : json(nullptr);
}

json realtime_json(const ServiceContext& context) {
  const RealtimeSettings& asked = context.settings.realtime;
  static constexpr const char* kModes[] = {"enforce", "prefer", "off"};
  json result{{"mode", kModes[static_cast<std::size_t>(asked.mode)]},
              {"estimate_threads", context.board.events.size()},
              {"asked", nullptr},
              {"got", nullptr}};
  if (asked.mode == RealtimeMode::off) return result;
  result["asked"] = {{"priority", asked.priority}, {"cpus", asked.cpus}, {"lock_memory", asked.lock_memory}};
  result["got"] = {{"priority", context.realtime.scheduling ? json(asked.priority) : json(nullptr)},
                   {"cpus", context.realtime.cpus ? json(asked.cpus) : json::array()},
                   {"lock_memory", context.realtime.memory_locked}};
  if (!context.realtime.refusal.empty()) result["refused"] = context.realtime.refusal;
  return result;
}

// Quantiles in us; null if there are no values.
json latency_json(const LatencyHistogram::Summary& latency) {
  const auto known = [&](double value) { return latency.count > 0 ? json(value) : json(nullptr); };
  return {{"p50", known(latency.p50_us)},
          {"p99", known(latency.p99_us)},
          {"p99.9", known(latency.p999_us)},
          {"max", known(latency.max_us)}};
}

// The error of the method in use on single frames of unseen contacts of this sensor's scene. What to expect
// over a grasp is each estimate's sigma. Null if it is not measured yet, or cannot be, because single frames
// of this sensor do not determine the margin.
json single_frame_error(const ServiceContext& context, const DeviceFacts& facts) {
  const TradeoffRow* used = nullptr;
  for (const TradeoffRow& row : facts.tradeoff.rows) {
    const bool rank_fits = row.settings.rank == context.settings.estimator.rank;
    if (row.method == facts.method && (used == nullptr || rank_fits)) used = &row;
  }
  if (used == nullptr || !std::isfinite(used->mean_error)) return nullptr;
  return {{"mean", used->mean_error},
          {"p95", used->p95_error},
          {"answered", used->answered},
          {"us_per_frame", used->p50_us}};
}

// Frames by what spoke against them; only what occurred.
json implausible_json(const SensorStatus& status) {
  json counts = json::object();
  for (std::size_t i = 1; i < kHealths; ++i) {
    const std::uint64_t frames = status.implausible[i].load(std::memory_order_relaxed);
    if (frames > 0) counts[std::string(to_string(static_cast<Health>(i)))] = frames;
  }
  return counts;
}

// Of frames that repeat; empty: few do.
std::string slower_than_frames(const ServiceContext& context, std::size_t sensor, const DeviceFacts& facts) {
  const double frames_hz = context.rates_hz[sensor], new_hz = frames_hz - context.repeats_hz[sensor];
  if (!measures_slower(frames_hz, context.repeats_hz[sensor])) return {};
  const double claimed_hz =
      facts.rate_hz > 0 ? facts.rate_hz : context.settings.sensors[sensor].setup.rate_hz;
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "%.1f of %.1f frames a second are new measurements, and rate_hz is %.4g: the others count for "
      "nothing; read the sensor as often as it measures",
      new_hz, frames_hz, claimed_hz);
  return text.data();
}

// Why there is no device, no estimator, no plausible frame, no zero of its own, or fewer measurements than
// frames; null: there is.
json trouble(const ServiceContext& context, std::size_t sensor, const DeviceFacts& facts,
             const Estimate& latest, std::int64_t now_ns) {
  const SensorStatus& status = *context.board.sensors[sensor];
  if (const std::string why = device_trouble(status, facts, now_ns); !why.empty()) return why;
  if (is_implausible(latest.health)) return describe(latest.health);
  const bool has_zero = !status.bias.needed.load(std::memory_order_relaxed) ||
                        status.bias.report.load().origin != BiasOrigin::none;
  if (has_zero && latest.state == State::unzeroed && facts.zero_trouble.empty()) return kZeroIsAnothers;
  if (const std::string slower = slower_than_frames(context, sensor, facts); !slower.empty()) return slower;
  return nullptr;
}

// Whether the device is open and its frames are fresh.
bool receiving(const SensorStatus& status, const Published& published) {
  const State state = published.estimate.state;
  return status.link.load(std::memory_order_relaxed) == DeviceLink::open && published.counts.received > 0 &&
         state != State::stale && state != State::fault;
}

json sensor_status(const ServiceContext& context, std::size_t sensor, std::int64_t now_ns) {
  const SensorStatus& status = *context.board.sensors[sensor];
  const Published published = as_of(now_ns, status);
  const DeviceFacts facts = status.facts();
  const FrameCounts& counts = published.counts;
  return {
      {"name", status.name},
      {"state", to_string(published.estimate.state)},
      {"alert", to_string(published.estimate.alert)},
      {"sliding", published.estimate.sliding ? json(to_string(*published.estimate.sliding)) : json(nullptr)},
      {"driver", status.driver},
      {"device", facts.description},
      {"connected", status.link.load(std::memory_order_relaxed) == DeviceLink::open},
      {"receiving", receiving(status, published)},
      {"simulated", status.simulated.load(std::memory_order_relaxed)},
      {"method", facts.method.empty() ? json(nullptr) : json(facts.method)},
      {"single_frame_error", single_frame_error(context, facts)},
      {"zero", zero_json(status)},
      {"trouble", trouble(context, sensor, facts, published.estimate, now_ns)},
      {"health", to_string(published.estimate.health)},
      {"implausible", implausible_json(status)},
      {"received", counts.received},
      {"estimated", counts.estimated},
      {"skipped", counts.skipped},
      {"gaps", counts.gaps},
      {"repeated", status.repeated.load(std::memory_order_relaxed)},
      {"lost", counts.lost},
      {"corrupt", status.corrupt.load(std::memory_order_relaxed)},
      {"timeouts", status.timeouts.load(std::memory_order_relaxed)},
      {"reconnects", status.reconnects.load(std::memory_order_relaxed)},
      {"events_lost", status.events_lost.load(std::memory_order_relaxed)},
      {"rate_hz", context.rates_hz[sensor]},
      {"latency_us", latency_json(status.latency.summary())},
      {"latency_last_minute_us", latency_json(context.latency_last_minute[sensor].summary(status.latency))}};
}

json recorder_json(const ServiceContext& context) {
  if (context.flight == nullptr) return "off";
  const std::uint64_t kept = context.flight->files_written();  // before the outcomes, which then know of them
  const std::uint64_t failed = context.flight->failures();
  json last = json::array();
  for (std::size_t i = 0; i < context.board.sensors.size(); ++i) {
    const FlightOutcome outcome = context.flight->outcome(i);
    if (outcome.number == 0) continue;
    last.push_back({{"sensor", context.board.sensors[i]->name},
                    {"recording", outcome.number},
                    {"file", outcome.file.empty() ? json(nullptr) : json(outcome.file)},
                    {"trouble", outcome.trouble.empty() ? json(nullptr) : json(outcome.trouble)}});
  }
  return {{"folder", context.flight->folder().string()},
          {"kept", kept},
          {"failed", failed},
          {"last", std::move(last)}};
}

json can_json(const ServiceContext& context) {
  const can::Report report = context.can->load();
  json withheld = json::array();
  const std::vector<std::string> sources = can::source_names(context.settings);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if ((report.withheld >> i & 1U) != 0) withheld.push_back(sources[i]);
  }
  const bool absent = report.bus == can::Bus::absent && report.error != 0;
  return {{"interface", context.settings.can->interface},
          {"state", to_string(report.bus)},
          {"trouble", absent ? json(can::why_no_can(report.error)) : json(nullptr)},
          {"sent", report.sent},
          {"queue_full", report.full},
          {"failed", report.failed},
          {"bus_errors", report.bus_errors},
          {"bus_offs", report.bus_offs},
          {"reopened", report.reopened},
          {"withheld", std::move(withheld)}};
}

}  // namespace

json zero_json(const SensorStatus& status) {
  if (!status.bias.needed.load(std::memory_order_relaxed)) return nullptr;
  const BiasReport zero = status.bias.report.load();
  const std::string trouble = status.facts().zero_trouble;
  const std::int64_t now_ns = Now::read().monotonic_ns;
  const auto age_s = [&](std::int64_t time_ns) { return 1e-9 * static_cast<double>(now_ns - time_ns); };
  const bool known = zero.origin != BiasOrigin::none;
  const auto if_known = [&](const json& value) { return known ? value : json(nullptr); };
  return {{"origin", to_string(zero.origin)},
          {"restored", zero.restored},
          {"taken_s_ago", if_known(age_s(zero.taken_ns))},
          {"confirmed_s_ago", if_known(age_s(zero.confirmed_ns))},
          {"free", zero.free},
          {"noise_normal_pa", if_known(zero.noise_normal_pa)},
          {"noise_shear_pa", if_known(zero.noise_shear_pa)},
          {"drift_pa", if_known(zero.drift_pa)},
          {"trouble", trouble.empty() ? json(nullptr) : json(trouble)}};
}

json status_json(const ServiceContext& context) {
  const std::chrono::duration<double> uptime = std::chrono::steady_clock::now() - context.started;
  json sensors = json::array();
  const std::int64_t now_ns = Now::read().monotonic_ns;
  for (std::size_t i = 0; i < context.board.sensors.size(); ++i)
    sensors.push_back(sensor_status(context, i, now_ns));
  json outputs{{"socket",
                {{"path", context.settings.socket.path.string()},
                 {"dropped", context.notifications_dropped},
                 {"owed_bytes", context.owed_bytes()},
                 {"held_back", context.clients_held_back},
                 {"refused", context.requests_refused},
                 {"latency_us", latency_json(context.delivery_latency.summary())},
                 {"latency_last_minute_us",
                  latency_json(context.delivery_latency_last_minute.summary(context.delivery_latency))}}}};
  if (context.can != nullptr) outputs["can"] = can_json(context);
  return {{"version", SLIPD_VERSION},
          {"uptime_s", uptime.count()},
          {"pid", getpid()},
          {"sensors", std::move(sensors)},
          {"realtime", realtime_json(context)},
          {"recorder", recorder_json(context)},
          {"recordings", {{"written", context.recordings->written}, {"failed", context.recordings->failed}}},
          {"outputs", std::move(outputs)},
          {"clients", context.clients}};
}

json sensors_json(const ServiceContext& context) {
  static constexpr const char* kClasses[] = {"array3", "wrench", "normal", "displacement"};
  json sensors = json::array();
  const std::int64_t now_ns = Now::read().monotonic_ns;
  for (std::size_t i = 0; i < context.board.sensors.size(); ++i) {
    const SensorStatus& status = *context.board.sensors[i];
    const DeviceFacts facts = status.facts();
    const SensorSetup& setup = context.settings.sensors[i].setup;
    const bool opened = facts.layout.has_value();
    sensors.push_back(
        {{"name", status.name},
         {"driver", status.driver},
         {"class", opened ? json(kClasses[static_cast<std::size_t>(facts.sensor_class)]) : json(nullptr)},
         {"taxels", opened ? json(facts.layout->size()) : json(nullptr)},
         {"rate_hz", facts.rate_hz > 0 ? facts.rate_hz : setup.rate_hz},
         {"method", facts.method.empty() ? json(nullptr) : json(facts.method)},
         {"method_reason", facts.method_reason.empty() ? json(nullptr) : json(facts.method_reason)},
         {"simulated", status.simulated.load(std::memory_order_relaxed)},
         {"connected", status.link.load(std::memory_order_relaxed) == DeviceLink::open},
         {"receiving", receiving(status, as_of(now_ns, status))},
         {"device", facts.description},
         {"serial", facts.serial.empty() ? json(nullptr) : json(facts.serial)}});
  }
  return {{"sensors", std::move(sensors)}};
}

json tradeoff_json(const std::string& sensor, const std::string& chosen, double budget_us,
                   const WorkPrecision& work_precision) {
  json table = json::array();
  for (const auto& row : work_precision.rows) {
    table.push_back({{"method", row.method},
                     {"rank", setting(row.settings.rank)},
                     {"rings", setting(row.settings.rings)},
                     {"neighbours", setting(row.settings.neighbours)},
                     {"precision", to_string(row.settings.precision)},
                     {"memory_bytes", row.settings.memory_bytes},
                     {"mean_error", number(row.mean_error)},
                     {"p95_error", number(row.p95_error)},
                     {"class_right", number(row.right)},
                     {"answered", number(row.answered)},
                     {"within_sigma", number(row.within_sigma)},
                     {"within_two_sigma", number(row.within_two_sigma)},
                     {"p50_us", number(row.p50_us)},
                     {"p99_us", number(row.p99_us)}});
  }
  return {{"sensor", sensor},
          {"chosen", chosen},
          {"budget_us", number(budget_us)},
          {"processor", work_precision.processor},
          {"rows", std::move(table)}};
}

}  // namespace slipd
