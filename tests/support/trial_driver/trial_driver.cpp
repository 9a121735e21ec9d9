// slipd-driver-trial.so: a device for tests of the daemon. It presses a sphere and loads it to a margin that
// it states as the truth, and misbehaves as its options ask. Not installed.
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/contact/traction.hpp"
#include "drivers/driver.hpp"

namespace {

using namespace slipd;
using Clock = std::chrono::steady_clock;

constexpr const char* kOptions = R"({"type": "object", "additionalProperties": false, "properties": {
  "behaviour": {"enum": ["steady", "hang_in_read", "hang_in_open", "throw_in_create", "throw_in_open",
    "vanish", "end", "wrong_sensor", "allocate"], "default": "steady", "description": "What goes wrong, after `after` frames."},
  "after": {"type": "integer", "minimum": 0, "default": 0, "unit": "frames", "description": "Frames before that."},
  "gap_every": {"type": "integer", "minimum": 0, "default": 0, "description": "Leave a sequence number out."},
  "corrupt_every": {"type": "integer", "minimum": 0, "default": 0, "description": "Report a corrupt packet."},
  "burst": {"type": "boolean", "default": false, "description": "Frames as fast as they can be made."},
  "paced": {"type": "boolean", "default": false, "description": "Wait for the consumer."},
  "gamma": {"type": "number", "minimum": 0, "maximum": 1, "default": 0.5, "description": "The margin it shows."}
}})";

[[noreturn]] void hang() {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

class TrialDriver : public DeviceDriver {
 public:
  explicit TrialDriver(const std::vector<SensorSetup>& sensors)
      : sensors_(sensors), options_(sensors.front().options) {
    behaviour_ = options_.at("behaviour");
    after_ = options_.at("after");
    gap_every_ = options_.at("gap_every");
    corrupt_every_ = options_.at("corrupt_every");
    burst_ = options_.at("burst");
    paced_ = options_.at("paced");
    gamma_ = options_.at("gamma");
    if (behaviour_ == "throw_in_create") throw DriverError("the trial device cannot be made: it was told so");
    vanishes_ = behaviour_ == "vanish";
    hangs_ = behaviour_ == "hang_in_read";
    ends_ = behaviour_ == "end";
    lies_ = behaviour_ == "wrong_sensor";
    allocates_ = behaviour_ == "allocate";
    draw();
  }

  DeviceInfo open() override {
    if (behaviour_ == "hang_in_open") hang();
    if (behaviour_ == "throw_in_open") throw DriverError("trial device 7 is not there: plug it in");
    DeviceInfo info{.description = "trial device", .serial = "7", .simulated = true, .sensors = {}};
    for (const auto& sensor : sensors_)
      info.sensors.push_back({.layout = sensor.layout, .rate_hz = sensor.rate_hz, .zeroed = true});
    given_ = 0;
    next_ = Clock::now();
    return info;
  }

  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override {
    const std::uint64_t turn = ++turns_;
    if (allocates_) garbage_ = std::make_unique<std::string>(100, 'x');
    if (corrupt_every_ > 0 && turn % corrupt_every_ == 0) return {ReadStatus::corrupt, 0};
    if (given_ >= after_) {
      if (hangs_) hang();
      if (vanishes_) return {ReadStatus::disconnected, 0};
      if (ends_) return {ReadStatus::end, 0};
      if (lies_) return {ReadStatus::frame, static_cast<std::uint16_t>(sensors_.size())};
    }
    if (!burst_ && !paced_) {
      if (next_ > Clock::now() + timeout) {
        std::this_thread::sleep_for(timeout);
        return {};
      }
      std::this_thread::sleep_until(next_);
      next_ += std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / sensors_.front().rate_hz));
    }
    const auto sensor = static_cast<std::uint16_t>(given_++ % sensors_.size());
    FrameSlot& slot = slots[sensor];
    std::copy(normal_[sensor].begin(), normal_[sensor].end(), slot.normal_pa.begin());
    std::copy(shear_[sensor].begin(), shear_[sensor].end(), slot.shear_x_pa.begin());
    std::fill(slot.shear_y_pa.begin(), slot.shear_y_pa.end(), 0.0F);
    if (gap_every_ > 0 && given_ % gap_every_ == 0) sequence_ += sensors_.size();
    slot.sequence = sequence_++ / sensors_.size();
    slot.time_ns = std::chrono::nanoseconds(Clock::now().time_since_epoch()).count();
    slot.device_time_ns = -1;
    slot.truth = {gamma_, kFriction};
    return {ReadStatus::frame, sensor};
  }

  void close() noexcept override {}
  bool paced_by_consumer() const noexcept override { return paced_; }

 private:
  static constexpr double kFriction = 0.5;

  void draw() {
    const auto pair = contact::make_pair({0.01, 0.5e6, 0.45}, {INFINITY, 2e11, 0.25});
    const contact::RisingLoad load(pair, 2.0, kFriction, 1 - gamma_);
    for (const auto& sensor : sensors_) {
      auto& normal = normal_.emplace_back();
      auto& shear = shear_.emplace_back();
      for (std::size_t i = 0; i < sensor.layout.size(); ++i) {
        const double r = std::hypot(sensor.layout.x_m()[i], sensor.layout.y_m()[i]);
        const auto here = load.at(r / load.contact_radius_m());
        normal.push_back(static_cast<float>(here.pressure_pa));
        shear.push_back(static_cast<float>(here.shear_pa));
      }
    }
  }

  std::vector<SensorSetup> sensors_;
  nlohmann::json options_;
  std::string behaviour_;
  std::uint64_t after_ = 0, gap_every_ = 0, corrupt_every_ = 0;
  bool burst_ = false, paced_ = false, vanishes_ = false, hangs_ = false, ends_ = false, lies_ = false,
       allocates_ = false;
  double gamma_ = 0.5;
  std::unique_ptr<std::string> garbage_;
  std::vector<std::vector<float>> normal_, shear_;
  std::uint64_t turns_ = 0, given_ = 0, sequence_ = 0;
  Clock::time_point next_;
};

std::unique_ptr<DeviceDriver> create(const std::vector<SensorSetup>& sensors) {
  return std::make_unique<TrialDriver>(sensors);
}

const DriverModule kModule{kDriverAbi, "trial", "a device that misbehaves as it is told, for tests", kOptions,
                           create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
