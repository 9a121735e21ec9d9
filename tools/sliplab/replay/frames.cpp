#include "tools/sliplab/replay/frames.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <utility>

#include "config/settings.hpp"
#include "core/zero/bias_estimator.hpp"
#include "core/zero/gain.hpp"
#include "drivers/decode/profile.hpp"
#include "drivers/replay/options.hpp"
#include "drivers/replay/playlist.hpp"
#include "embedded/replay_options.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/replay/camera_frames.hpp"

namespace sliplab {

using namespace slipd;

namespace {

// Knows the options of `replay`; any options of any other driver will do, as its device is not opened.
class ReplayCatalogue final : public DriverCatalogue {
 public:
  const DriverModule* find(const std::string& name) override { return name == "replay" ? &replay_ : &any_; }
  std::string why_not(const std::string&) override { return {}; }
  std::vector<std::string> names() override { return {"replay"}; }

 private:
  DriverModule replay_{kDriverAbi, "replay", "", replay_options.data(), nullptr};
  DriverModule any_{kDriverAbi, "any", "", R"({"type": "object"})", nullptr};
};

std::string file_of(const SensorSettings& sensor) {
  return sensor.driver == "replay" ? sensor.setup.options.value("file", "") : "";
}

std::vector<const SensorSettings*> chosen_sensors(const Settings& settings, const std::string& name) {
  std::vector<const SensorSettings*> chosen;
  std::string known;
  for (const SensorSettings& sensor : settings.sensors) {
    if (name.empty() || sensor.setup.name == name) chosen.push_back(&sensor);
    known += (known.empty() ? "" : ", ") + sensor.setup.name;
  }
  if (chosen.empty()) throw offline::WrongUse("the scene has no sensor " + name + "; it has " + known);
  return chosen;
}

const SensorSettings& sensor_of(const Settings& settings, const std::string& name) {
  return *chosen_sensors(settings, name).front();
}

// As the device of its profile reports it; none: the sensor has no profile.
std::optional<SensorInfo> info_of_profile(const SensorSettings& sensor) {
  if (sensor.setup.profile.empty()) return std::nullopt;
  return decode::info_of(decode::find_profile(sensor.setup.profile), "");
}

SensorSetup setup_of(const SensorSettings& sensor, const std::optional<SensorInfo>& info,
                     const std::string& file) {
  SensorSetup setup = sensor.setup;
  if (info) setup.layout = info->layout;
  if (sensor.driver != "replay" && !is_video(file)) setup.options = nlohmann::json::object();
  if (is_video(file)) return setup;
  setup.options["file"] = file;
  setup.options["loop"] = false;
  return setup;
}

}  // namespace

struct FileFrames::Impl {
  Impl(const Settings& settings, const SensorSettings& sensor, const std::optional<SensorInfo>& info,
       const std::string& file)
      : Impl(settings, sensor, info ? info->skin : std::nullopt, setup_of(sensor, info, file), file) {}

  Impl(const Settings& settings, const SensorSettings& sensor, const std::optional<SkinInfo>& skin,
       const SensorSetup& setup, const std::string& file)
      : list(is_video(file) ? nullptr
                            : std::make_unique<replay::Playlist>(setup, replay::parse_options(setup))),
        camera(is_video(file) ? std::make_unique<CameraFrames>(setup, file) : nullptr),
        chain{.layout = setup.layout,
              .sensor_class = list ? list->sensor_class() : camera->sensor_class(),
              .scene = settings.scene_of(sensor, skin),
              .estimator = settings.estimator,
              .alerts = settings.alerts,
              .friction = sensor.friction,
              .full_scale = sensor.full_scale,
              .contact = sensor.contact},
        bias(setup.layout),
        unzeroed(list && !list->zeroed()),
        gain(sensor.gain),
        memory(3 * setup.layout.size()) {
    const std::size_t taxels = setup.layout.size();
    const std::span<float> all(memory);
    slot.normal_pa = all.first(taxels);
    slot.shear_x_pa = all.subspan(taxels, taxels);
    slot.shear_y_pa = all.last(taxels);
    if (gain.size() == 1) gain.assign(setup.layout.size(), gain.front());
  }

  replay::ReadOutcome read() { return list ? list->next(slot) : camera->next(slot); }

  std::unique_ptr<replay::Playlist> list;  // null: frames are of a video
  std::unique_ptr<CameraFrames> camera;
  ChainSetup chain;
  BiasEstimator bias;
  bool unzeroed, biased = false;
  std::vector<float> gain;
  std::vector<float> memory;  // of slot
  FrameSlot slot;
  std::string fault;
};

FileFrames::FileFrames(const Settings& settings, const FileOfSensor& of)
    : impl_(std::make_unique<Impl>(settings, sensor_of(settings, of.sensor),
                                   info_of_profile(sensor_of(settings, of.sensor)), of.file)) {}
FileFrames::FileFrames(FileFrames&&) noexcept = default;
FileFrames& FileFrames::operator=(FileFrames&&) noexcept = default;
FileFrames::~FileFrames() = default;

const ChainSetup& FileFrames::setup() const noexcept {
  return impl_->chain;
}
Frame FileFrames::frame() const noexcept {
  return impl_->slot.view();
}
std::int64_t FileFrames::time_ns() const noexcept {
  return impl_->slot.time_ns;
}
std::size_t FileFrames::unrisen() const noexcept {
  return impl_->list ? impl_->list->unrisen() : 0;
}
std::optional<double> FileFrames::rate_hz() const noexcept {
  return impl_->list ? std::optional(impl_->list->rate_hz()) : std::nullopt;
}
const std::string& FileFrames::fault() const noexcept {
  return impl_->fault;
}

FileFrames::Outcome FileFrames::next() {
  Impl& in = *impl_;
  if (in.biased) in.bias.judge();
  in.biased = false;
  replay::ReadOutcome outcome = in.read();
  while (outcome == replay::ReadOutcome::none) outcome = in.read();
  switch (outcome) {
    case replay::ReadOutcome::end:
      return Outcome::end;
    case replay::ReadOutcome::damaged:
      in.fault = in.list ? in.list->fault() : in.camera->fault();
      return Outcome::end;
    case replay::ReadOutcome::corrupt:
      return Outcome::corrupt;
    default:
      break;
  }
  in.slot.zeroed = true;
  if (in.unzeroed) in.bias.apply(in.slot);
  in.biased = in.unzeroed;
  apply_gain(in.gain, in.slot);
  return Outcome::frame;
}

Settings load_scene(const std::filesystem::path& scene) {
  ReplayCatalogue drivers;
  return load_settings(scene, drivers);
}

std::vector<FileOfSensor> files_of(const Settings& settings, const std::string& sensor_name,
                                   const std::vector<std::string>& files) {
  const std::vector<const SensorSettings*> sensors = chosen_sensors(settings, sensor_name);
  std::vector<FileOfSensor> jobs;
  std::vector<std::string> anyones;
  for (const std::string& file : files) {
    const auto named = std::find_if(sensors.begin(), sensors.end(), [&](const SensorSettings* sensor) {
      return file.starts_with(sensor->setup.name + "=");
    });
    if (named == sensors.end()) {
      anyones.push_back(file);
    } else {
      jobs.push_back({(*named)->setup.name, file.substr((*named)->setup.name.size() + 1)});
    }
  }
  std::set<std::string> own;
  for (const SensorSettings* sensor : sensors) own.insert(file_of(*sensor));
  if (files.empty()) {
    for (const SensorSettings* sensor : sensors) jobs.push_back({sensor->setup.name, file_of(*sensor)});
  } else if (sensors.size() > 1 && anyones.size() == sensors.size() && own.size() == sensors.size()) {
    for (std::size_t i = 0; i < sensors.size(); ++i) jobs.push_back({sensors[i]->setup.name, anyones[i]});
  } else {
    for (const std::string& file : anyones) {
      for (const SensorSettings* sensor : sensors) jobs.push_back({sensor->setup.name, file});
    }
  }
  for (const FileOfSensor& job : jobs) {
    if (job.file.empty()) throw offline::WrongUse("sensor " + job.sensor + " has no file: give one");
  }
  return jobs;
}

}  // namespace sliplab
