#include "tests/tools/samples.hpp"

#include <algorithm>
#include <cmath>

namespace slipctl::testing {

using nlohmann::json;

json estimate_sample(const std::string& sensor, std::uint64_t sequence, double gamma) {
  return {{"sensor", sensor},
          {"seq", sequence},
          {"time_ns", 1790000000000000000},
          {"state", "ok"},
          {"gamma", gamma},
          {"sigma", 0.01},
          {"class", std::min(4, static_cast<int>(5 * gamma)) + 1},
          {"friction", 0.45},
          {"friction_sigma", 0.02},
          {"normal_n", 2.1},
          {"shear_n", 0.36},
          {"center_mm", {0.1, -0.4}},
          {"radius_mm", 3.1},
          {"a_over_r", 0.31},
          {"torque_nmm", -1.2},
          {"torque_sigma_nmm", 0.05},
          {"time_to_slip_ms", nullptr},
          {"grip_increase_n", 0.5},
          {"alert", gamma < 0.2   ? "slip"
                    : gamma < 0.4 ? "warn"
                                  : "none"},
          {"alert_cause", gamma < 0.4 ? json("margin") : json(nullptr)},
          {"sliding", "none"},
          {"sliding_for_ms", 2500.0},
          {"method", "moments"},
          {"simulated", true},
          {"latency_us", 35.2},
          {"age_ms", 0.8},
          {"dropped", 0},
          {"truth", {{"gamma", gamma + 0.005}, {"friction", 0.44}}}};
}

json frame_sample(int columns, int rows) {
  json frame{{"seq", 1}, {"time_ns", 1790000000000000000}};
  for (const char* key : {"normal_pa", "shear_x_pa", "shear_y_pa", "x_mm", "y_mm"})
    frame[key] = json::array();
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double x = (column - (columns - 1) / 2.0) / columns;
      const double y = (row - (rows - 1) / 2.0) / rows;
      const double pressure = 50e3 * std::sqrt(std::max(0.0, 1 - 9 * (x * x + y * y)));
      frame["normal_pa"].push_back(pressure);
      frame["shear_x_pa"].push_back(0.3 * pressure);
      frame["shear_y_pa"].push_back(0.0);
      frame["x_mm"].push_back(14.4 * x);
      frame["y_mm"].push_back(14.4 * y * rows / columns);
    }
  return frame;
}

json sensors_sample(const std::vector<std::string>& names) {
  json sensors = json::array();
  for (const std::string& name : names)
    sensors.push_back({{"name", name},
                       {"driver", "sim"},
                       {"class", "array3"},
                       {"taxels", 10000},
                       {"rate_hz", 1000.0},
                       {"method", "moments"},
                       {"simulated", true},
                       {"connected", true}});
  return {{"sensors", sensors}};
}

json status_sample(const std::vector<std::string>& names, std::uint64_t received) {
  json sensors = json::array();
  for (const std::string& name : names)
    sensors.push_back({{"name", name},
                       {"received", received},
                       {"estimated", received - 3},
                       {"skipped", 3},
                       {"corrupt", 0},
                       {"gaps", 0},
                       {"reconnects", 0},
                       {"rate_hz", 999.7},
                       {"latency_us", {{"p50", 33.0}, {"p99", 61.0}, {"p99.9", 90.0}, {"max", 141.0}}}});
  return {{"uptime_s", 12.5}, {"clients", 1}, {"sensors", sensors}};
}

WatchState watch_sample(int sensors, const std::string& state) {
  WatchState watch;
  watch.socket = "/run/slipd/slipd.sock";
  for (int i = 0; i < sensors; ++i) {
    const std::string name = "s" + std::to_string(i);
    SensorWatch sensor;
    sensor.info = sensors_from(sensors_sample({name})).front();
    sensor.counts = counts_from(status_sample({name}, 10000)).front();
    take_frame(sensor, frame_from(frame_sample(32, 32)));
    watch.sensors.push_back(std::move(sensor));
  }
  for (int step = 0; step <= 1000; ++step) {
    watch.elapsed_s = step / 100.0;
    for (const SensorWatch& sensor : watch.sensors) {
      json estimate = estimate_sample(sensor.info.name, static_cast<std::uint64_t>(step),
                                      0.5 + 0.45 * std::cos(step / 100.0));
      estimate["state"] = state;
      if (state != "ok")
        for (const char* key : {"gamma", "sigma", "class"}) estimate[key] = nullptr;
      take_estimate(watch, estimate_from(estimate));
    }
  }
  return watch;
}

}  // namespace slipctl::testing
