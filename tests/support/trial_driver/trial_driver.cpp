// slipd-driver-trial.so: a device for tests of the daemon. It presses a sphere and loads it to a margin that
// it states as the truth, and misbehaves as its options ask. Not installed.
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <thread>

#include "core/contact/cattaneo_mindlin.hpp"
#include "driver_api/driver.hpp"

namespace {

using namespace slipd;
using Clock = std::chrono::steady_clock;

constexpr const char* kOptions = R"({"type": "object", "additionalProperties": false, "properties": {
  "behaviour": {"enum": ["steady", "silent", "hang_in_read", "hang_in_open", "throw_in_create", "throw_in_open",
    "throw_oddly_in_open", "vanish", "end", "wrong_sensor", "allocate", "nonsense"], "default": "steady",
    "description": "What goes wrong, after `after` frames."},
  "after": {"type": "integer", "minimum": 0, "default": 0, "unit": "frames",
    "description": "Frames before that: since it was opened, or, if it ends, since it was made."},
  "troubles": {"type": "integer", "minimum": 0, "default": 0,
    "description": "Seed of random ones: corrupt packets, gaps, silences, long reads, unplugs. 0: none."},
  "gate": {"type": "string", "default": "", "description": "It is silent until this file is there."},
  "well_until": {"type": "string", "default": "", "description": "Nothing goes wrong until this file is there."},
  "account": {"type": "string", "default": "",
    "description": "File to write to, when it is closed, how many frames, gaps, corrupt ones and unplugs there were."},
  "gap_every": {"type": "integer", "minimum": 0, "default": 0, "description": "Leave a sequence number out."},
  "corrupt_every": {"type": "integer", "minimum": 0, "default": 0, "description": "Report a corrupt packet."},
  "burst": {"type": "boolean", "default": false, "description": "Frames as fast as they can be made."},
  "scan": {"type": "boolean", "default": false,
    "description": "A frame of each sensor at every tick, as on a bus; else the sensors take turns."},
  "place": {"type": "integer", "minimum": 0, "default": 0, "description": "Which of the bus it is: any number."},
  "paced": {"type": "boolean", "default": false, "description": "Wait for the consumer."},
  "simulated": {"type": "boolean", "default": true, "description": "What it says of itself."},
  "gamma": {"type": "number", "minimum": 0, "maximum": 1, "default": 0.5, "description": "The margin it shows."}
}})";

[[noreturn]] void hang() {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

// Random faults, the same for the same seed.
class Troubles {
 public:
  enum class Kind : std::uint8_t { none, corrupt, gap, silence, long_read, unplug };
  explicit Troubles(std::uint64_t seed) : random_(static_cast<std::minstd_rand::result_type>(seed)) {}

  // The fault of the next frame; none for all but one in a thousand or so.
  Kind next() {
    static constexpr struct {
      unsigned in_80000;
      Kind kind;
    } kOdds[] = {
        {20, Kind::corrupt}, {20, Kind::gap}, {10, Kind::silence}, {5, Kind::long_read}, {10, Kind::unplug}};
    unsigned drawn = static_cast<unsigned>(random_() % 80000);
    for (const auto& [in_80000, kind] : kOdds) {
      if (drawn < in_80000) return kind;
      drawn -= in_80000;
    }
    return Kind::none;
  }
  unsigned up_to(unsigned most) { return 1 + static_cast<unsigned>(random_() % most); }

 private:
  std::minstd_rand random_;  // NOLINT(cert-msc51-cpp): the same in every run
};

class TrialDriver : public DeviceDriver {
 public:
  explicit TrialDriver(const std::vector<SensorSetup>& sensors)
      : sensors_(sensors), options_(sensors.front().options) {
    behaviour_ = options_.at("behaviour");
    after_ = options_.at("after");
    gap_every_ = options_.at("gap_every");
    corrupt_every_ = options_.at("corrupt_every");
    burst_ = options_.at("burst");
    scan_ = options_.at("scan");
    paced_ = options_.at("paced");
    gamma_ = options_.at("gamma");
    gate_ = options_.at("gate").get<std::string>();
    well_until_ = options_.at("well_until").get<std::string>();
    account_ = options_.at("account").get<std::string>();
    if (const std::uint64_t seed = options_.at("troubles"); seed > 0) troubles_.emplace(seed);
    if (behaviour_ == "throw_in_create")
      throw DriverError("the trial device cannot be made: its options say so");
    vanishes_ = behaviour_ == "vanish";
    hangs_ = behaviour_ == "hang_in_read";
    silent_ = behaviour_ == "silent";
    ends_ = behaviour_ == "end";
    lies_ = behaviour_ == "wrong_sensor";
    allocates_ = behaviour_ == "allocate";
    raves_ = behaviour_ == "nonsense";
    draw();
  }

  DeviceInfo open() override {
    if (behaviour_ == "hang_in_open") hang();
    if (behaviour_ == "throw_in_open") throw DriverError("trial device 7 is not there: plug it in");
    if (behaviour_ == "throw_oddly_in_open") throw 7;
    if (unplugged_ && troubles_ && troubles_->up_to(2) == 1) throw DriverError("trial device 7 is unplugged");
    unplugged_ = false;
    DeviceInfo info{
        .description = "trial device", .serial = "7", .simulated = options_.at("simulated"), .sensors = {}};
    for (const auto& sensor : sensors_)
      info.sensors.push_back({.layout = sensor.layout, .rate_hz = sensor.rate_hz, .zeroed = true});
    given_ = 0;
    fresh_ = true;
    next_ = Clock::now();
    return info;
  }

  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override {
    const std::uint64_t turn = ++turns_;
    if (allocates_) garbage_ = std::make_unique<std::string>(100, 'x');
    if (corrupt_every_ > 0 && turn % corrupt_every_ == 0) return {ReadStatus::corrupt, 0};
    if (!gate_.empty() && !gate_opened()) {
      std::this_thread::sleep_for(timeout);
      return {};
    }
    if (ends_ && sent_.frames >= after_ && !is_well()) return {ReadStatus::end, 0};
    if (given_ >= after_ && !is_well()) {
      if (hangs_) hang();
      if (silent_) {
        std::this_thread::sleep_for(timeout);
        return {};
      }
      if (vanishes_) return {ReadStatus::disconnected, 0};
      if (lies_) return {ReadStatus::frame, static_cast<std::uint16_t>(sensors_.size())};
    }
    if (silent_until_ > Clock::now()) {
      std::this_thread::sleep_for(timeout);
      return {};
    }
    if (troubles_ && !decided_) {
      const ReadStatus instead = run_into_trouble();
      if (instead != ReadStatus::frame) return {instead, 0};
    }
    const bool in_scan = scan_ && given_ % sensors_.size() != 0;
    if (!burst_ && !paced_ && !in_scan) {
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
    // No frame is one of those before: that would be no new evidence, or a block that is played again.
    const float other = 1 + kStep * static_cast<float>(given_ / sensors_.size() % kOthers);
    for (float& pressure : slot.normal_pa) pressure *= other;
    for (float& shear : slot.shear_x_pa) shear *= other;
    if (raves_ && given_ > after_ && !is_well())  // far more shear than any friction holds
      for (float& shear : slot.shear_x_pa) shear *= kTooMuch;
    std::fill(slot.shear_y_pa.begin(), slot.shear_y_pa.end(), 0.0F);
    if (gap_every_ > 0 && given_ % gap_every_ == 0) sequence_ += sensors_.size();
    fresh_ = decided_ = false;
    ++sent_.frames;
    slot.sequence = 1 + sequence_++ / sensors_.size();
    slot.time_ns = std::chrono::nanoseconds(Clock::now().time_since_epoch()).count();
    slot.device_time_ns = -1;
    slot.truth = {gamma_, kFriction};
    return {ReadStatus::frame, sensor};
  }

  void close() noexcept override {
    if (account_.empty()) return;
    std::ofstream(account_) << nlohmann::json{{"frames", sent_.frames},
                                              {"left_out", sent_.left_out},
                                              {"corrupt", sent_.corrupt},
                                              {"unplugs", sent_.unplugs}};
  }
  bool paced_by_consumer() const noexcept override { return paced_; }

 private:
  static constexpr double kFriction = 0.5;
  static constexpr float kTooMuch = 20;
  static constexpr float kStep = 4e-7F;
  static constexpr std::uint64_t kOthers = 251;

  bool gate_opened() {
    std::error_code ignored;
    if (std::filesystem::exists(gate_, ignored)) gate_.clear();
    next_ = Clock::now();
    return gate_.empty();
  }

  bool is_well() {
    std::error_code ignored;
    if (!well_until_.empty() && std::filesystem::exists(well_until_, ignored)) well_until_.clear();
    return !well_until_.empty();
  }

  // The status that read returns instead of a frame; `frame`: no fault, or one that does not prevent the
  // frame.
  ReadStatus run_into_trouble() {
    using namespace std::chrono_literals;
    switch (troubles_->next()) {
      case Troubles::Kind::corrupt:
        ++sent_.corrupt;
        return ReadStatus::corrupt;
      case Troubles::Kind::gap:
        if (fresh_) break;  // before the first frame a gap cannot be noticed
        sent_.left_out += 3;
        sequence_ += 3 * sensors_.size();
        break;
      case Troubles::Kind::silence:
        silent_until_ = Clock::now() + troubles_->up_to(150) * 1ms;
        return ReadStatus::timeout;
      case Troubles::Kind::long_read:
        std::this_thread::sleep_for(troubles_->up_to(200) * 1ms);
        break;
      case Troubles::Kind::unplug:
        ++sent_.unplugs;
        unplugged_ = true;
        return ReadStatus::disconnected;
      case Troubles::Kind::none:
        break;
    }
    decided_ = true;  // until this frame has been delivered
    return ReadStatus::frame;
  }

  void draw() {
    const auto pair = contact::make_body_pair({0.01, 0.5e6, 0.45}, {INFINITY, 2e11, 0.25});
    const contact::CattaneoMindlin load(pair, 2.0, kFriction, 1 - gamma_);
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
  bool burst_ = false, scan_ = false, paced_ = false, vanishes_ = false, hangs_ = false, silent_ = false,
       ends_ = false, lies_ = false, allocates_ = false, raves_ = false;
  double gamma_ = 0.5;
  std::unique_ptr<std::string> garbage_;
  std::vector<std::vector<float>> normal_, shear_;
  std::uint64_t turns_ = 0, given_ = 0, sequence_ = 0;
  Clock::time_point next_, silent_until_;
  std::string gate_, well_until_, account_;
  std::optional<Troubles> troubles_;
  bool unplugged_ = false, fresh_ = true, decided_ = false;
  struct {
    std::uint64_t frames = 0, left_out = 0, corrupt = 0, unplugs = 0;
  } sent_;
};

std::unique_ptr<DeviceDriver> create(const std::vector<SensorSetup>& sensors) {
  return std::make_unique<TrialDriver>(sensors);
}

const DriverModule kModule{kDriverAbi, "trial", "a device that misbehaves as its options say, for tests",
                           kOptions, create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
