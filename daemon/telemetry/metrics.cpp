// Metrics as text: each family with its type and help, one line a sensor; as OpenMetrics ended by # EOF.
#include "daemon/telemetry/metrics.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string>

#include "daemon/board/as_of.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

constexpr double kMmPerM = 1e3;

std::string label_text(const std::string& value) {
  std::string text;
  for (const char c : value) {
    if (c == '\n') {
      text += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text;
}

class Families {
 public:
  Families(const ServiceContext& context, MetricsFormat format) : context_(context), format_(format) {
    out_.precision(std::numeric_limits<double>::max_digits10);
  }

  // One sample for each sensor whose value is not NaN. The name of a counter's samples ends in _total.
  void add(const std::string& name, const char* type, const char* help,
           const std::function<double(std::size_t)>& value) {
    head(name, type, help);
    for (std::size_t i = 0; i < context_.board.sensors.size(); ++i) {
      const double number = value(i);
      if (std::isnan(number)) continue;
      out_ << sample(name, type) << "{sensor=\"" << label_text(context_.board.sensors[i]->name) << "\"} "
           << number << '\n';
    }
  }

  // A counter for each sensor and each health but good.
  void implausible() {
    const std::string name = "slipd_frames_implausible";
    head(name, "counter", "Frames by what spoke against them.");
    for (const auto& status : context_.board.sensors) {
      for (std::size_t i = 1; i < kHealths; ++i) {
        out_ << sample(name, "counter") << "{sensor=\"" << label_text(status->name) << "\",health=\""
             << to_string(static_cast<Health>(i)) << "\"} "
             << status->implausible[i].load(std::memory_order_relaxed) << '\n';
      }
    }
  }

  void add_one(const std::string& name, const char* type, const char* help, double value) {
    head(name, type, help);
    out_ << sample(name, type) << ' ' << value << '\n';
  }

  // A constant 1 with the version as label. A gauge, because not every collector knows the type info.
  void build(const char* version) {
    head("slipd_build_info", "gauge", "Which slipd this is.");
    out_ << "slipd_build_info{version=\"" << version << "\"} 1\n";
  }

  // `labels`: put before the quantile, each with a comma behind it; may be empty.
  void quantiles(const std::string& name, const std::string& labels,
                 const LatencyHistogram::Summary& latency) {
    if (latency.count == 0) return;
    const auto line = [&](const char* quantile, double microseconds) {
      out_ << name << '{' << labels << "quantile=\"" << quantile << "\"} " << microseconds * 1e-6 << '\n';
    };
    line("0.5", latency.p50_us);
    line("0.99", latency.p99_us);
    line("0.999", latency.p999_us);
    line("1", latency.max_us);
  }

  void seconds(const std::string& name, const char* type, const char* help) {
    head(name, type, help);
    if (format_ == MetricsFormat::open_metrics) out_ << "# UNIT " << name << " seconds\n";
  }

  void latencies() {
    const auto sensor = [&](std::size_t i) {
      return "sensor=\"" + label_text(context_.board.sensors[i]->name) + "\",";
    };
    seconds("slipd_latency_seconds", "summary", "From the sample to its published estimate.");
    for (std::size_t i = 0; i < context_.board.sensors.size(); ++i) {
      const auto latency = context_.board.sensors[i]->latency.summary();
      quantiles("slipd_latency_seconds", sensor(i), latency);
      if (latency.count > 0) {
        out_ << "slipd_latency_seconds_count{sensor=\"" << label_text(context_.board.sensors[i]->name)
             << "\"} " << latency.count << '\n';
      }
    }
    seconds("slipd_latency_last_minute_seconds", "gauge", "The same over the last minute.");
    for (std::size_t i = 0; i < context_.board.sensors.size(); ++i) {
      quantiles("slipd_latency_last_minute_seconds", sensor(i),
                context_.latency_last_minute[i].summary(context_.board.sensors[i]->latency));
    }
    const auto delivery = context_.delivery_latency.summary();
    seconds("slipd_delivery_seconds", "summary",
            "From an estimate being published to its last byte sent to a subscriber.");
    quantiles("slipd_delivery_seconds", "", delivery);
    if (delivery.count > 0) out_ << "slipd_delivery_seconds_count " << delivery.count << '\n';
    seconds("slipd_delivery_last_minute_seconds", "gauge", "The same over the last minute.");
    quantiles("slipd_delivery_last_minute_seconds", "",
              context_.delivery_latency_last_minute.summary(context_.delivery_latency));
  }

  std::string text() const { return out_.str() + (format_ == MetricsFormat::open_metrics ? "# EOF\n" : ""); }

 private:
  static std::string sample(const std::string& name, const std::string& type) {
    return type == "counter" ? name + "_total" : name;
  }
  // In OpenMetrics the family of a counter has no _total, in the Prometheus format it has.
  void head(const std::string& name, const char* type, const char* help) {
    const std::string family = format_ == MetricsFormat::open_metrics ? name : sample(name, type);
    out_ << "# TYPE " << family << ' ' << type << "\n# HELP " << family << ' ' << help << '\n';
  }

  const ServiceContext& context_;
  const MetricsFormat format_;
  std::ostringstream out_;
};

using PublishedBySensor = std::vector<Published>;

double number(std::uint64_t value) {
  return static_cast<double>(value);
}

double loaded(const std::atomic<std::uint64_t>& counter) {
  return number(counter.load(std::memory_order_relaxed));
}

void add_counts(Families& families, const ServiceContext& context, const PublishedBySensor& published) {
  const auto status = [&](std::size_t i) -> const SensorStatus& { return *context.board.sensors[i]; };
  families.add("slipd_frames_received", "counter", "Frames that the driver handed over.",
               [&](std::size_t i) { return number(published[i].counts.received); });
  families.add("slipd_frames_estimated", "counter", "Frames that were answered by an estimate.",
               [&](std::size_t i) { return number(published[i].counts.estimated); });
  families.add("slipd_frames_skipped", "counter",
               "Frames replaced by a newer one before the estimator came to them.",
               [&](std::size_t i) { return number(published[i].counts.skipped); });
  families.add("slipd_frames_corrupt", "counter", "Packets or frames that the driver threw away.",
               [&](std::size_t i) { return loaded(status(i).corrupt); });
  families.add("slipd_frames_lost", "counter",
               "Frames missing between those received, by their sequence numbers.",
               [&](std::size_t i) { return number(published[i].counts.lost); });
  families.add("slipd_gaps", "counter", "Jumps of the sequence number.",
               [&](std::size_t i) { return number(published[i].counts.gaps); });
  families.add("slipd_reconnects", "counter", "Times that the device was opened again.",
               [&](std::size_t i) { return loaded(status(i).reconnects); });
  families.add("slipd_read_timeouts", "counter", "Reads of the device that brought nothing in time.",
               [&](std::size_t i) { return loaded(status(i).timeouts); });
  families.add("slipd_events_lost", "counter", "Estimates that io was too slow to send to subscribers.",
               [&](std::size_t i) { return loaded(status(i).events_lost); });
  families.add("slipd_estimates_per_second", "gauge", "Estimates a second, over the last second.",
               [&](std::size_t i) { return context.rates_hz[i]; });
}

void add_states(Families& families, const ServiceContext& context, const PublishedBySensor& published) {
  const auto status = [&](std::size_t i) -> const SensorStatus& { return *context.board.sensors[i]; };
  const auto known = [](const std::optional<double>& value) { return value.value_or(kUnknown); };
  families.add("slipd_connected", "gauge", "1 while the device is open.", [&](std::size_t i) {
    return status(i).link.load(std::memory_order_relaxed) == DeviceLink::open ? 1.0 : 0.0;
  });
  families.add("slipd_state", "gauge",
               "0 ok, 1 no_contact, 2 learning, 3 out_of_model, 4 no_shear, 5 unzeroed, 6 stale, 7 fault.",
               [&](std::size_t i) { return static_cast<double>(published[i].estimate.state); });
  families.add("slipd_gamma", "gauge", "Safety margin, 1 no tangential load, 0 gross slip; only in state ok.",
               [&](std::size_t i) {
                 const Estimate& estimate = published[i].estimate;
                 return estimate.state == State::ok ? known(estimate.gamma) : kUnknown;
               });
  families.add("slipd_torque_newton_millimetres", "gauge",
               "Torque about the contact's normal, positive from x to y; where the sensor shows one.",
               [&](std::size_t i) {
                 const auto& torque_nm = published[i].estimate.torque_nm;
                 return torque_nm ? kMmPerM * *torque_nm : kUnknown;
               });
  families.add("slipd_alert", "gauge", "0 none, 1 warn, 2 slip, 3 unknown.",
               [&](std::size_t i) { return static_cast<double>(published[i].estimate.alert); });
  families.add("slipd_sliding", "gauge",
               "0 none, 1 disturbed, 2 translation, 3 rotation; only where the sensor can show it.",
               [&](std::size_t i) {
                 const auto& sliding = published[i].estimate.sliding;
                 return sliding ? static_cast<double>(*sliding) : kUnknown;
               });
  families.add("slipd_simulated", "gauge", "1 for a simulated sensor.", [&](std::size_t i) {
    return status(i).simulated.load(std::memory_order_relaxed) ? 1.0 : 0.0;
  });
  families.add("slipd_zeroed", "gauge", "1 if it is known what the sensor reads without load.",
               [&](std::size_t i) { return status(i).bias.known() ? 1.0 : 0.0; });
  families.add("slipd_zero_drift_pascals", "gauge", "How far the zero has followed drift since it was taken.",
               [&](std::size_t i) { return static_cast<double>(status(i).bias.report.load().drift_pa); });
}

void add_service(Families& families, const ServiceContext& context) {
  families.build(SLIPD_VERSION);
  const std::chrono::duration<double> uptime = std::chrono::steady_clock::now() - context.started;
  families.add_one("slipd_uptime_seconds", "gauge", "Since the start.", uptime.count());
  families.add_one("slipd_realtime_scheduling", "gauge", "1 if real-time scheduling was granted.",
                   context.realtime.scheduling ? 1 : 0);
  families.add_one("slipd_realtime_memory_locked", "gauge", "1 if memory is locked.",
                   context.realtime.memory_locked ? 1 : 0);
  families.add_one("slipd_clients", "gauge", "Clients on the socket.", number(context.clients));
  families.add_one("slipd_notifications_dropped", "counter", "Notifications that slow clients have lost.",
                   number(context.notifications_dropped));
  families.add_one("slipd_answers_owed_bytes", "gauge", "Answers that clients requested and have not read.",
                   number(context.owed_bytes()));
  families.add_one("slipd_clients_held_back", "counter",
                   "Times that a client was not read from because it did not read its answers.",
                   number(context.clients_held_back));
  families.add_one("slipd_requests_refused", "counter", "Requests refused because clients do not read.",
                   number(context.requests_refused));
}

void add_recordings(Families& families, const ServiceContext& context) {
  families.add_one("slipd_recordings", "counter", "Recordings that clients asked for and got.",
                   number(context.recordings->written));
  families.add_one("slipd_recordings_failed", "counter", "Recordings that clients asked for and that failed.",
                   number(context.recordings->failed));
  if (context.flight == nullptr) return;
  families.add_one("slipd_flight_recordings", "counter", "Recordings that the flight recorder has written.",
                   number(context.flight->files_written()));
  families.add_one("slipd_flight_recordings_failed", "counter",
                   "Recordings that the flight recorder could not write.",
                   number(context.flight->failures()));
}

void add_can(Families& families, const can::Report& can) {
  families.add_one("slipd_can_state", "gauge",
                   "0 absent, 1 down, 2 up, 3 error_warning, 4 error_passive, 5 bus_off.",
                   static_cast<double>(can.bus));
  families.add_one("slipd_can_sent", "counter", "CAN messages that the kernel took.", number(can.sent));
  families.add_one("slipd_can_queue_full", "counter", "Attempts to send for which there was no room.",
                   number(can.full));
  families.add_one("slipd_can_failed", "counter", "Attempts to send that were refused.", number(can.failed));
  families.add_one("slipd_can_bus_errors", "counter", "Error frames of the CAN controller.",
                   number(can.bus_errors));
  families.add_one("slipd_can_bus_offs", "counter", "Times that the CAN controller went off the bus.",
                   number(can.bus_offs));
}

}  // namespace

std::string metrics_text(const ServiceContext& context, MetricsFormat format) {
  PublishedBySensor published;
  const std::int64_t now_ns = Now::read().monotonic_ns;
  for (const auto& status : context.board.sensors) published.push_back(as_of(now_ns, *status));
  Families families(context, format);
  add_counts(families, context, published);
  families.implausible();
  add_states(families, context, published);
  families.latencies();
  add_service(families, context);
  add_recordings(families, context);
  if (context.can != nullptr) add_can(families, context.can->load());
  return families.text();
}

}  // namespace slipd
