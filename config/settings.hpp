// A configuration, checked and in SI units. Read once at start and on reload, by the io thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/estimate/settings.hpp"
#include "driver_api/driver.hpp"

namespace slipd {

struct SensorSettings {
  SensorSetup setup;  // what its driver is told
  std::string driver;
  std::chrono::milliseconds stale_after{20};
  bool stale_after_told = false;  // by the user; else a slower device has three of its frames
  std::optional<double> friction;
  std::vector<float> gain;  // one for all taxels, or one for each
  bool operator==(const SensorSettings&) const = default;
};

struct GraspSettings {
  std::string name;
  std::vector<std::string> sensors;
};

struct SocketSettings {
  std::filesystem::path path{"/run/slipd/slipd.sock"};
  unsigned mode = 0660;
  std::size_t max_clients = 64;
};

struct CanSettings {
  std::string interface;
  std::uint32_t base_id = 0x5A0;
  bool extended = false;
  bool fd = false;
  std::chrono::milliseconds period{10};
  bool allow_simulated = false;
};

struct RecorderSettings {
  double seconds = 0;  // 0: off
  double max_mb = 256;
  int keep = 20;
};

// Metrics in a file for a collector that reads files, such as node_exporter's.
struct MetricsSettings {
  std::filesystem::path file;  // empty: none is written
  std::chrono::seconds period{15};
};

enum class RealtimeMode : std::uint8_t { enforce, prefer, off };

struct RealtimeSettings {
  RealtimeMode mode = RealtimeMode::prefer;
  int priority = 60;
  std::vector<int> cpus;
  bool lock_memory = true;
  bool operator==(const RealtimeSettings&) const = default;
};

struct Settings {
  std::vector<SensorSettings> sensors;
  std::vector<GraspSettings> grasps;
  std::vector<ObjectFamily> objects;
  EstimatorSettings estimator;
  double noise = 0.01;  // the scene's, see Scene
  double offset_m = 0.002;
  AlertSettings alerts;
  SocketSettings socket;
  std::optional<CanSettings> can;  // absent: no CAN thread
  RecorderSettings recorder;
  MetricsSettings metrics;
  RealtimeSettings realtime;
  std::string log_level = "info";

  Scene scene_of(const SensorSettings& sensor) const;
};

// One line a problem: `FILE: /json/pointer = value: what is wrong, the range and unit`.
class SettingsError : public std::runtime_error {
 public:
  explicit SettingsError(std::vector<std::string> problems);
  const std::vector<std::string>& problems() const noexcept { return problems_; }

 private:
  std::vector<std::string> problems_;
};

// The schema of a driver's options, by the driver's name; nullptr for a driver that is not there. Lets the
// daemon look into its modules, and tests do without any.
class DriverCatalogue {
 public:
  virtual ~DriverCatalogue() = default;
  virtual const DriverModule* find(const std::string& name) = 0;  // null: no such driver, see why_not
  virtual std::string why_not(const std::string& name) = 0;  // what was looked for and found, for the error
  virtual std::vector<std::string> names() = 0;
};

// JSON with comments → Settings. Throws SettingsError with every problem found, not only the first.
// `name` stands before each problem (the file's name).
Settings parse_settings(const std::string& text, const std::string& name, DriverCatalogue& drivers);
Settings load_settings(const std::filesystem::path& file, DriverCatalogue& drivers);

}  // namespace slipd
