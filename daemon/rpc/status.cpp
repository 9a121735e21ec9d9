#include "daemon/rpc/status.hpp"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "daemon/rt/clock.hpp"
#include "daemon/can/dbc.hpp"
#include "daemon/record/flight_recorder.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;

json realtime_json(const World& world) {
  const RealtimeSettings& asked = world.settings.realtime;
  static constexpr const char* kModes[] = {"enforce", "prefer", "off"};
  json result{{"mode", kModes[static_cast<std::size_t>(asked.mode)]}, {"asked", nullptr}, {"got", nullptr}};
  if (asked.mode == RealtimeMode::off) return result;
  result["asked"] = {{"priority", asked.priority}, {"cpus", asked.cpus}, {"lock_memory", asked.lock_memory}};
  result["got"] = {{"priority", world.realtime.scheduling ? json(asked.priority) : json(nullptr)},
                   {"cpus", world.realtime.cpus ? json(asked.cpus) : json::array()},
                   {"lock_memory", world.realtime.memory_locked}};
  if (!world.realtime.refusal.empty()) result["refused"] = world.realtime.refusal;
  return result;
}

// From the sample to its published estimate; null where there was none.
json latency_json(const LatencyHistogram::Summary& latency) {
  const auto known = [&](double value) { return latency.count > 0 ? json(value) : json(nullptr); };
  return {{"p50", known(latency.p50_us)},
          {"p99", known(latency.p99_us)},
          {"p99.9", known(latency.p999_us)},
          {"max", known(latency.max_us)}};
}

std::string can_trouble(int error) {
  if (error == EMSGSIZE) return "it is not set up for FD frames: set its mtu to 72, or can.fd to false";
  if (error == EAFNOSUPPORT) return "this kernel has no CAN: load its module can-raw";
  if (error == ENODEV) return "there is no such interface: plug it in, or correct can.interface";
  return std::generic_category().message(error);
}

// Of the method in use, measured on unseen contacts of this sensor's scene. Null where it was not: it is
// still being measured, or single frames of this sensor do not tell their margin.
json expected_error(const World& world, const DeviceFacts& facts) {
  const TradeoffRow* used = nullptr;
  for (const TradeoffRow& row : facts.tradeoff.rows) {
    const bool rank_fits = row.settings.rank == world.settings.estimator.rank;
    if (row.method == facts.method && (used == nullptr || rank_fits)) used = &row;
  }
  if (used == nullptr || !std::isfinite(used->mean_error)) return nullptr;
  return {{"mean", used->mean_error},
          {"p95", used->p95_error},
          {"answered", used->answered},
          {"us_per_frame", used->p50_us}};
}

json sensor_status(const World& world, std::size_t sensor) {
  const Panel& panel = *world.board.sensors[sensor];
  const Published reading = panel.latest.load();
  const DeviceFacts facts = panel.facts();
  const Counts& counts = reading.counts;
  return {{"name", panel.name},
          {"state", to_string(reading.estimate.state)},
          {"alert", to_string(reading.estimate.alert)},
          {"driver", panel.driver},
          {"device", facts.description},
          {"connected", panel.link.load(std::memory_order_relaxed) == Link::open},
          {"simulated", panel.simulated.load(std::memory_order_relaxed)},
          {"method", facts.method.empty() ? json(nullptr) : json(facts.method)},
          {"expected_error", expected_error(world, facts)},
          {"zero", zero_json(panel)},
          {"trouble", facts.trouble.empty() ? json(nullptr) : json(facts.trouble)},
          {"received", counts.received},
          {"estimated", counts.estimated},
          {"skipped", counts.skipped},
          {"gaps", counts.gaps},
          {"lost", counts.lost},
          {"corrupt", panel.corrupt.load(std::memory_order_relaxed)},
          {"timeouts", panel.timeouts.load(std::memory_order_relaxed)},
          {"reconnects", panel.reconnects.load(std::memory_order_relaxed)},
          {"events_lost", panel.events_lost.load(std::memory_order_relaxed)},
          {"rate_hz", world.rates_hz[sensor]},
          {"latency_us", latency_json(panel.latency.summary())},
          {"latency_last_minute_us", latency_json(world.last_minute[sensor].summary(panel.latency))}};
}

json recorder_json(const World& world) {
  if (world.flight == nullptr) return "off";
  return {{"folder", world.flight->folder().string()},
          {"kept", world.flight->kept()},
          {"failed", world.flight->failed()}};
}

json can_json(const World& world) {
  const can::Report report = world.can->load();
  json withheld = json::array();
  const std::vector<std::string> subjects = can::subjects_of(world.settings);
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    if ((report.withheld >> i & 1U) != 0) withheld.push_back(subjects[i]);
  }
  const bool absent = report.bus == can::Bus::absent && report.error != 0;
  return {{"interface", world.settings.can->interface},
          {"state", to_string(report.bus)},
          {"trouble", absent ? json(can_trouble(report.error)) : json(nullptr)},
          {"sent", report.sent},
          {"queue_full", report.full},
          {"failed", report.failed},
          {"bus_errors", report.bus_errors},
          {"bus_offs", report.bus_offs},
          {"reopened", report.reopened},
          {"withheld", std::move(withheld)}};
}

}  // namespace

json zero_json(const Panel& panel) {
  if (!panel.zero.needed.load(std::memory_order_relaxed)) return nullptr;
  const ZeroReport zero = panel.zero.report.load();
  const std::string trouble = panel.facts().zero_trouble;
  const std::int64_t now_ns = Now::read().monotonic_ns;
  const auto age_s = [&](std::int64_t time_ns) { return 1e-9 * static_cast<double>(now_ns - time_ns); };
  const bool known = zero.origin != ZeroOrigin::none;
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

json status_json(const World& world) {
  const std::chrono::duration<double> uptime = std::chrono::steady_clock::now() - world.started;
  json sensors = json::array();
  for (std::size_t i = 0; i < world.board.sensors.size(); ++i) sensors.push_back(sensor_status(world, i));
  json outputs{{"socket",
                {{"path", world.settings.socket.path.string()},
                 {"dropped", world.notifications_dropped},
                 {"latency_us", latency_json(world.told.summary())},
                 {"latency_last_minute_us", latency_json(world.told_last_minute.summary(world.told))}}}};
  if (world.can != nullptr) outputs["can"] = can_json(world);
  return {
      {"version", SLIPD_VERSION},      {"uptime_s", uptime.count()},       {"pid", getpid()},
      {"sensors", std::move(sensors)}, {"realtime", realtime_json(world)}, {"recorder", recorder_json(world)},
      {"outputs", std::move(outputs)}, {"clients", world.clients}};
}

json sensors_json(const World& world) {
  static constexpr const char* kClasses[] = {"array3", "wrench", "normal"};
  json sensors = json::array();
  for (std::size_t i = 0; i < world.board.sensors.size(); ++i) {
    const Panel& panel = *world.board.sensors[i];
    const DeviceFacts facts = panel.facts();
    const SensorSetup& setup = world.settings.sensors[i].setup;
    const bool opened = facts.layout.has_value();
    sensors.push_back(
        {{"name", panel.name},
         {"driver", panel.driver},
         {"class", opened ? json(kClasses[static_cast<std::size_t>(facts.sensor_class)]) : json(nullptr)},
         {"taxels", opened ? json(facts.layout->size()) : json(nullptr)},
         {"rate_hz", facts.rate_hz > 0 ? facts.rate_hz : setup.rate_hz},
         {"method", facts.method.empty() ? json(nullptr) : json(facts.method)},
         {"simulated", panel.simulated.load(std::memory_order_relaxed)},
         {"connected", panel.link.load(std::memory_order_relaxed) == Link::open},
         {"device", facts.description},
         {"serial", facts.serial.empty() ? json(nullptr) : json(facts.serial)}});
  }
  return {{"sensors", std::move(sensors)}};
}

}  // namespace slipd
