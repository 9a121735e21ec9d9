// The configuration, checked and in SI units. Read at start and on reload by io; constant afterwards, so that
// any thread may read it. Ranges and defaults are in slipd.schema.json; the defaults here are the same.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/estimate/settings.hpp"
#include "core/grasp/finger_pose.hpp"
#include "core/health/limits.hpp"
#include "driver_api/driver.hpp"
#include "schema/settings_error.hpp"

namespace slipd {

// Which keys of `skin` the configuration has. These are used instead of the device's own.
struct SkinKeys {
  bool radius = false;
  bool modulus = false;
  bool poisson = false;
  bool depth = false;
  bool base = false;
  bool operator==(const SkinKeys&) const = default;
};

// One sensor.
struct SensorSettings {
  // What its driver gets.
  SensorSetup setup;
  // The driver's name.
  std::string driver;
  // Without a frame for this long the estimate is stale, 1 to 60000 ms.
  std::chrono::milliseconds stale_after{20};
  // Whether stale_after was in the configuration. If not, three frames of a slower device are allowed.
  bool stale_after_configured = false;
  // Of the log of setup.skin_depth_m, standard deviation; see Skin.
  double skin_depth_sigma = kUsualDepthSigma;
  // Which of setup.skin_… the configuration has; the others are defaults.
  SkinKeys skin_keys = {};
  // Coefficient of friction, a value or a range within 0.01 to 10; none: as the expected objects have it.
  std::optional<KnownFriction> friction;
  // The largest values that its taxels can read, Pa; none: those of its class.
  std::optional<FullScale> full_scale = std::nullopt;
  // When there is a contact.
  ContactSettings contact = {};
  // Factors of the taxels' values: one for each taxel, or one for all.
  std::vector<float> gain;
  bool operator==(const SensorSettings&) const = default;
};

// Sensors that hold one object.
struct GraspSettings {
  // Unique among the grasps.
  std::string name;
  // Names of its sensors, at least one.
  std::vector<std::string> sensors;
  // Where they are, in their order; or none.
  std::vector<FingerPose> poses;
};

// The socket that clients connect to.
struct SocketSettings {
  // Where it is; at most 107 bytes. Not used if systemd passes the socket.
  std::filesystem::path path{"/run/slipd/slipd.sock"};
  // Permissions of the file.
  unsigned mode = 0660;
  // Clients connected at the same time; further ones are refused.
  std::size_t max_clients = 64;
};

// The CAN output.
struct CanSettings {
  // Name of the network interface.
  std::string interface;
  // Identifier of the first message; daemon/can/encode.hpp has the offsets of the others.
  std::uint32_t base_id = 0x5A0;
  // Identifiers of 29 bits instead of 11.
  bool extended = false;
  // CAN FD frames instead of classic ones.
  bool fd = false;
  // Time between two estimates of a sensor, ms.
  std::chrono::milliseconds period{10};
  // Whether estimates of simulated sensors are sent.
  bool allow_simulated = false;
  // Whether a message beside each estimate says if the object slides; it has 32 more identifiers.
  bool sliding = false;
};

// The flight recorder.
struct RecorderSettings {
  // Seconds kept before and after an alert; 0: off.
  double seconds = 0;
  // Memory for the frames of all sensors, MB.
  double max_mb = 256;
  // Recordings of slips kept on disk, and as many requested ones; the oldest are removed.
  int keep = 20;
};

// Metrics in a file, for a collector that reads files, such as node_exporter.
struct MetricsSettings {
  // Where; empty: no file is written.
  std::filesystem::path file;
  // Time between two writes, s.
  std::chrono::seconds period{15};
};

// What to do when the system refuses real-time privileges.
enum class RealtimeMode : std::uint8_t {
  enforce,  // do not start
  prefer,   // warn and run without
  off       // do not request any
};

// Real-time scheduling.
struct RealtimeSettings {
  RealtimeMode mode = RealtimeMode::prefer;
  // Priority of SCHED_FIFO, 1 to 99.
  int priority = 60;
  // CPUs that real-time threads run on; empty: all.
  std::vector<int> cpus;
  // Threads that estimate; 0: as many as its sensors need.
  int estimate_threads = 0;
  // Whether to lock all memory.
  bool lock_memory = true;
  bool operator==(const RealtimeSettings&) const = default;
};

// The whole configuration.
struct Settings {
  std::vector<SensorSettings> sensors;
  std::vector<GraspSettings> grasps;
  // Objects that the scene consists of; see Scene.
  std::vector<ObjectFamily> objects;
  EstimatorSettings estimator;
  // Noise of the scene; see Scene.
  double noise = 0.01;
  // Offset of contacts in the scene, m; see Scene.
  double offset_m = 0.002;
  AlertSettings alerts;
  SocketSettings socket;
  // None: no CAN output.
  std::optional<CanSettings> can;
  RecorderSettings recorder;
  MetricsSettings metrics;
  RealtimeSettings realtime;
  // trace, debug, info, warning or error.
  std::string log_level = "info";

  // The scene of one sensor: its skin and what all sensors share. `of_device`: the skin that the device
  // defines, such as by its profile; the configuration's keys replace its values. None: as configured.
  Scene scene_of(const SensorSettings& sensor, const std::optional<SkinInfo>& of_device = {}) const;
};

// Finds drivers by name. The daemon implements it with loadable modules, tests without. Called from one
// thread: io.
class DriverCatalogue {
 public:
  virtual ~DriverCatalogue() = default;
  // The driver's module; null: there is none that can be used, see why_not.
  virtual const DriverModule* find(const std::string& name) = 0;
  // Why find returned null, for people.
  virtual std::string why_not(const std::string& name) = 0;
  // Names of all drivers, usable or not.
  virtual std::vector<std::string> names() = 0;
};

// Parses JSON with comments. `name` is the file's name, for messages. Throws SettingsError with every problem
// found, not only the first.
Settings parse_settings(const std::string& text, const std::string& name, DriverCatalogue& drivers);
// The same from a file of at most 16 MB. Throws SettingsError too if it cannot be read.
Settings load_settings(const std::filesystem::path& file, DriverCatalogue& drivers);

}  // namespace slipd
