#include "tools/sliplab/replay/run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "config/settings.hpp"
#include "core/bias/bias_estimator.hpp"
#include "core/bias/gain.hpp"
#include "core/estimate/chain.hpp"
#include "core/estimate/model_setup.hpp"
#include "core/model/model.hpp"
#include "drivers/replay/options.hpp"
#include "drivers/replay/playlist.hpp"
#include "embedded/replay_options.hpp"
#include "tools/sliplab/command.hpp"

namespace sliplab {
namespace {

using namespace slipd;

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

struct Job {
  const SensorSettings* sensor;
  std::string file;
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
  if (chosen.empty()) throw WrongUse("the scene has no sensor " + name + "; it has " + known);
  return chosen;
}

std::vector<Job> jobs_of(const std::vector<const SensorSettings*>& sensors,
                         const std::vector<std::string>& files) {
  std::vector<Job> jobs;
  std::vector<std::string> anyones;
  for (const std::string& file : files) {
    const auto named = std::find_if(sensors.begin(), sensors.end(), [&](const SensorSettings* sensor) {
      return file.starts_with(sensor->setup.name + "=");
    });
    if (named == sensors.end()) {
      anyones.push_back(file);
    } else {
      jobs.push_back({*named, file.substr((*named)->setup.name.size() + 1)});
    }
  }
  std::set<std::string> own;
  for (const SensorSettings* sensor : sensors) own.insert(file_of(*sensor));
  if (files.empty()) {
    for (const SensorSettings* sensor : sensors) jobs.push_back({sensor, file_of(*sensor)});
  } else if (sensors.size() > 1 && anyones.size() == sensors.size() && own.size() == sensors.size()) {
    for (std::size_t i = 0; i < sensors.size(); ++i) jobs.push_back({sensors[i], anyones[i]});
  } else {
    for (const std::string& file : anyones) {
      for (const SensorSettings* sensor : sensors) jobs.push_back({sensor, file});
    }
  }
  return jobs;
}

// A frame and its memory.
struct Slot {
  explicit Slot(std::size_t taxels) : memory(3 * taxels) {
    const std::span<float> all(memory);
    slot.normal_pa = all.first(taxels);
    slot.shear_x_pa = all.subspan(taxels, taxels);
    slot.shear_y_pa = all.last(taxels);
  }
  std::vector<float> memory;
  FrameSlot slot;
};

ReplayRun play(const Settings& settings, const Job& job) {
  const SensorSettings& sensor = *job.sensor;
  SensorSetup setup = sensor.setup;
  if (sensor.driver != "replay") setup.options = nlohmann::json::object();
  setup.options["file"] = job.file;
  setup.options["loop"] = false;
  replay::Playlist list(setup, replay::parse_options(setup));
  const ChainSetup chain_setup{.layout = setup.layout,
                               .sensor_class = list.sensor_class(),
                               .scene = settings.scene_of(sensor),
                               .estimator = settings.estimator,
                               .alerts = settings.alerts,
                               .friction = sensor.friction,
                               .full_scale = sensor.full_scale,
                               .contact = sensor.contact};
  if (needs_model(chain_setup))
    throw WrongUse("sensor " + setup.name + " needs a trained model: choose another estimator.method");
  EstimatorChain chain(chain_setup, nullptr);
  BiasEstimator bias(setup.layout);
  const bool unzeroed = !list.zeroed();
  std::vector<float> gain = sensor.gain;
  if (gain.size() == 1) gain.assign(setup.layout.size(), gain.front());
  ReplayRun run{.sensor = setup.name, .file = job.file, .rows = {}, .fault = {}};
  Slot frame(setup.layout.size());
  std::int64_t time_ns = 0;
  for (std::uint64_t row = 0;; ++row) {
    const replay::ReadOutcome outcome = list.next(frame.slot);
    if (outcome == replay::ReadOutcome::end) break;
    if (outcome == replay::ReadOutcome::damaged) {
      run.fault = list.fault();
      break;
    }
    ReplayRow& out = run.rows.emplace_back();
    out.row = row;
    if (outcome == replay::ReadOutcome::corrupt) {  // the daemon counts it and estimates nothing
      out.time_s = static_cast<double>(time_ns) * 1e-9;
      out.estimate.state = State::fault;
      if (row > 0) out.estimate.alert = run.rows[row - 1].estimate.alert;
      continue;
    }
    time_ns = frame.slot.time_ns;
    frame.slot.zeroed = true;
    if (unzeroed) bias.apply(frame.slot);
    apply_gain(gain, frame.slot);
    out.estimate = chain.estimate(frame.slot.view());
    out.time_s = static_cast<double>(time_ns) * 1e-9;
    if (unzeroed) bias.judge();
  }
  return run;
}

}  // namespace

std::vector<ReplayRun> replay(const std::filesystem::path& scene, const std::string& sensor,
                              const std::vector<std::string>& files) {
  ReplayCatalogue drivers;
  const Settings settings = load_settings(scene, drivers);
  std::vector<ReplayRun> runs;
  for (const Job& job : jobs_of(chosen_sensors(settings, sensor), files)) {
    if (job.file.empty())
      throw WrongUse("sensor " + job.sensor->setup.name + " has no file: give one with --file");
    runs.push_back(play(settings, job));
  }
  return runs;
}

}  // namespace sliplab
