// A catalogue of two drivers that do not exist, and shorthand for parsing with it.
#pragma once

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/settings.hpp"
#include "embedded/slipd_config_schema.hpp"
#include "schema/json_text.hpp"

namespace slipd::test {

class FakeCatalogue : public DriverCatalogue {
 public:
  const DriverModule* find(const std::string& name) override {
    return name == "sim" ? &sim_ : name == "replay" ? &replay_ : name == "broken" ? &broken_ : nullptr;
  }
  std::string why_not(const std::string& name) override {
    return name == "old" ? "it was built for driver interface 1" : "found: replay, sim; looked in /nowhere";
  }
  std::vector<std::string> names() override { return {"old", "replay", "sim"}; }

 private:
  DriverModule sim_{kDriverAbi, "sim", "a simulated sensor", R"({
    "type": "object", "additionalProperties": false, "properties": {
      "seed": { "type": "integer", "minimum": 0, "maximum": 1000000, "default": 1 },
      "noise": { "type": "number", "minimum": 0, "maximum": 1, "default": 0.01, "unit": "of full scale" } } })",
                    nullptr};
  DriverModule replay_{kDriverAbi, "replay", "a recording", R"({ "type": "object" })", nullptr};
  DriverModule broken_{kDriverAbi, "broken", "describes its options wrongly", R"({ "typ": "object" })",
                       nullptr};
};

inline Settings parse(const std::string& text) {
  FakeCatalogue drivers;
  return parse_settings(text, "t.json", drivers);
}
inline Settings parse(const nlohmann::json& document) {
  return parse(document.dump());
}

// The problems that parse() reports; empty: none.
template <typename Document>
std::vector<std::string> problems_of(const Document& document) {
  try {
    parse(document);
  } catch (const SettingsError& e) {
    return e.problems();
  }
  return {};
}

inline std::string text_of(const std::string& file) {
  std::ifstream in(std::string(SLIPD_SOURCE_DIR) + "/" + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline nlohmann::json schema() {
  return parse_json_text(slipd_config_schema);
}

// Every key of the configuration, within its range.
inline nlohmann::json whole_document() {
  return parse_json_text(R"({ "$schema": "s",
    "sensors": [
      { "name": "left", "driver": "sim", "rate_hz": 500, "stale_after_ms": 30,
        "layout": { "grid": [10, 20], "pitch_mm": 0.5 },
        "skin": { "radius_mm": "flat", "modulus_mpa": 1, "poisson": 0.4, "depth_mm": 1.5, "base": "rigid" },
        "device": { "index": 1 }, "friction": 0.5, "contact": { "min_normal_n": 0.2 }, "full_scale_kpa": [100, 50, 40], "options": { "seed": 3, "noise": 0.1 } },
      { "name": "right", "driver": "sim", "layout": { "taxels": [[0, 0], [1, 0], [0, 1]] }, "gain": 0.5 },
      { "name": "real", "driver": "replay", "profile": "xela-xr1944", "device": { "serial": "A1" } } ],
    "grasps": [ { "name": "gripper", "sensors": ["left", "right"],
                  "poses": [ { "at_mm": [0, 0, -20], "normal": [0, 0, 2], "x": [1, 0, 1] },
                             { "at_mm": [0, 0, 20], "normal": [0, 0, -1], "x": [1, 0, 0] } ] } ],
    "objects": [ { "weight": 2, "normal_n": [1, 6], "friction": [0.2, 0.8], "radius_mm": [5, 50], "flat_share": 0.25,
                   "modulus_mpa": [1, 10], "poisson": [0.1, 0.2] } ],
    "estimator": { "method": "fit", "budget_us": 60, "rank": 9, "neighbours": 6, "tracking": false, "sigma_max": 0.2,
                   "noise": 0.02, "offset_mm": 3 },
    "alerts": { "warn_below": 0.5, "slip_below": 0.3, "false_alarms_per_hour": 2, "use": "low", "hysteresis": 0.06, "min_ms": 3, "cost": 20, "target_margin": 0.6 },
    "socket": { "path": "/tmp/s", "mode": "0600", "max_clients": 10 },
    "can": { "interface": "can1", "base_id": "0x100", "extended": true, "fd": true, "period_ms": 20, "allow_simulated": true, "sliding": true },
    "recorder": { "seconds": 5, "max_mb": 10, "keep": 3 },
    "metrics": { "file": "/run/slipd/slipd.prom", "period_s": 30 },
    "realtime": { "mode": "enforce", "priority": 50, "cpus": [1, 2], "estimate_threads": 3, "lock_memory": false },
    "log": { "level": "debug" } })");
}

}  // namespace slipd::test
