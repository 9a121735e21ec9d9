// `sliplab skin`: how deep a sensor's taxels lie under its skin, by recordings of presses; and whether its
// shear has the signs and the order of its layout.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/settings.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/replay/frames.hpp"
#include "tools/sliplab/skin/depth.hpp"
#include "tools/sliplab/skin/shear_order.hpp"

namespace sliplab {
namespace {

using namespace slipd;

struct SkinOptions {
  std::string scene, sensor;
  std::vector<std::string> files;
  std::size_t frames = 40;
};

struct SkinReport {
  std::string sensor;
  std::optional<SkinDepth> depth;
  SkinBase base = SkinBase::half_space;  // of the scene
  bool flat = false;                     // skin.radius_mm of the scene
  // The depth with the other base, if presses show that this is the true one.
  std::optional<SkinDepth> with_other_base = {};
  ShearOrder order;
  std::size_t presses = 0;
};

SkinBase other_than(SkinBase base) {
  return base == SkinBase::rigid ? SkinBase::half_space : SkinBase::rigid;
}

// Both fitted to the same frames, one by more than chance and gains that differ make up: nats a frame.
bool clearly_likelier(const SkinDepth& one, const SkinDepth& other) {
  constexpr double kLeast = 2;
  return one.frames == other.frames &&
         other.misfit_nats - one.misfit_nats > kLeast * static_cast<double>(one.frames);
}

std::vector<PressFrame> read_all(FileFrames& source) {
  std::vector<PressFrame> frames;
  for (;;) {
    const FileFrames::Outcome outcome = source.next();
    if (outcome == FileFrames::Outcome::end) return frames;
    if (outcome == FileFrames::Outcome::corrupt) continue;
    const Frame frame = source.frame();
    frames.push_back({{frame.normal_pa.begin(), frame.normal_pa.end()},
                      {frame.shear_x_pa.begin(), frame.shear_x_pa.end()},
                      {frame.shear_y_pa.begin(), frame.shear_y_pa.end()}});
  }
}

// All files of one sensor together: some frames of each.
SkinReport measure(const Settings& settings, const std::string& sensor,
                   const std::vector<FileOfSensor>& files, std::size_t most) {
  SkinReport out{.sensor = sensor, .depth = {}, .order = {}};
  std::vector<PressFrame> presses;
  std::optional<ChainSetup> setup;
  for (const FileOfSensor& file : files) {
    FileFrames source(settings, file);
    setup = source.setup();
    if (setup->sensor_class != SensorClass::array3)
      throw offline::WrongUse("sensor " + sensor + " has no taxels with pressure and shear");
    if (setup->scene.skin.base == SkinBase::pillars)
      throw offline::WrongUse("sensor " + sensor + " has pillars (skin.base), which have no skin over them");
    const auto own =
        press_frames(setup->layout, read_all(source), std::max<std::size_t>(1, most / files.size()));
    presses.insert(presses.end(), own.begin(), own.end());
    if (!source.fault().empty()) std::cerr << "sliplab: " << source.fault() << '\n';
  }
  out.presses = presses.size();
  PatchFinder finder(setup->layout);
  for (const PressFrame& press : presses)
    out.order.add(setup->layout, finder.find({1, 1, press.normal_pa, press.shear_x_pa, press.shear_y_pa}));
  if (!advice_on(out.order.verdict()).empty()) return out;
  Skin skin = setup->scene.skin;
  out.base = skin.base;
  out.flat = std::isinf(skin.radius_m);
  const auto depth_on = [&](SkinBase base) {
    skin.base = base;
    return skin_depth(setup->layout, expected_friction(setup->scene), presses, skin.bonded_poisson());
  };
  out.depth = depth_on(out.base);
  if (out.depth && out.depth->depth_m > 0) {
    const auto other = depth_on(other_than(out.base));
    if (other && clearly_likelier(*other, *out.depth)) out.with_other_base = other;
  }
  return out;
}

void print(const SkinReport& report) {
  constexpr double kMm = 1e3;
  std::printf("%s: %zu frames of presses\n", report.sensor.c_str(), report.presses);
  const std::string_view advice = advice_on(report.order.verdict());
  if (!advice.empty()) {
    std::printf("  %.*s.\n  Put that right first: a depth from such shear means nothing.\n",
                static_cast<int>(advice.size()), advice.data());
    return;
  }
  if (!report.depth) {
    std::printf(
        "  no depth: press harder, with something round, and so that the whole contact is on the pad.\n");
    return;
  }
  const SkinDepth& depth = *report.depth;
  if (depth.depth_m > 0) {
    std::printf("  depth %.3g +- %.2g mm (one standard deviation)\n", kMm * depth.depth_m,
                kMm * depth.sigma_m);
  } else {
    std::printf("  taxels lie at the surface\n");
  }
  if (depth.gain_spread)
    std::printf("  gains differ by %.1f %% (one standard deviation)\n", 100 * *depth.gain_spread);
  std::printf("  write into the scene, at this sensor: \"skin\": { \"depth_mm\": %.3g }\n",
              kMm * depth.depth_m);
  if (report.flat)
    std::printf(
        "  The skin is flat, and there the depth has no effect. If the surface is curved, give "
        "skin.radius_mm, "
        "too.\n");
  if (report.with_other_base)
    std::printf("  but with skin.base \"%s\" and depth_mm %.3g the presses are much more likely\n",
                slipd::to_string(other_than(report.base)), kMm * report.with_other_base->depth_m);
}

nlohmann::ordered_json skin_json(const SkinReport& report) {
  nlohmann::ordered_json out{{"sensor", report.sensor},
                             {"frames", report.presses},
                             {"correlations", report.order.correlations()},
                             {"advice", advice_on(report.order.verdict())}};
  if (!report.depth) return out;
  out["depth_mm"] = 1e3 * report.depth->depth_m;
  out["depth_sigma_mm"] = 1e3 * report.depth->sigma_m;
  if (report.with_other_base) out["depth_mm_with_other_base"] = 1e3 * report.with_other_base->depth_m;
  if (report.depth->gain_spread) out["gain_spread"] = *report.depth->gain_spread;
  return out;
}

void run_skin(const offline::Common& common, const SkinOptions& options) {
  const Settings settings = load_scene(options.scene);
  const std::vector<FileOfSensor> files = files_of(settings, options.sensor, options.files);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const SensorSettings& sensor : settings.sensors) {
    std::vector<FileOfSensor> own;
    for (const FileOfSensor& file : files) {
      if (file.sensor == sensor.setup.name) own.push_back(file);
    }
    if (own.empty()) continue;
    const SkinReport report = measure(settings, sensor.setup.name, own, options.frames);
    if (common.json) {
      all.push_back(skin_json(report));
    } else {
      print(report);
    }
  }
  if (common.json) std::cout << all.dump(2) << '\n';
}

}  // namespace

void add_skin(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand(
      "skin", "find the depth of the taxels under the skin, and wrong signs of shear, from presses");
  auto options = std::make_shared<SkinOptions>();
  command->add_option("--scene", options->scene, "the configuration")->required()->check(CLI::ExistingFile);
  command->add_option("recordings", options->files,
                      "CSVs or recordings of presses, instead of the scene's; SENSOR=FILE for one sensor");
  command->add_option("--sensor", options->sensor, "only this sensor of the scene");
  command->add_option("--frames", options->frames, "frames to use at most")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->callback([&common, options] { run_skin(common, *options); });
}

}  // namespace sliplab
