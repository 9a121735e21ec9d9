#include "tests/bench/scenes.hpp"

#include <cstdlib>
#include <numbers>

#include "core/contact/scene_draws.hpp"
#include "drivers/sim/simulated_sensor.hpp"
#include "paper/model/model_file.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
#include "paper/validation/trial_frames.hpp"

namespace slipd::bench {

TaxelLayout pad(std::size_t side) {
  return TaxelLayout::grid(side, side, kPad_m / static_cast<double>(side));
}

Scene scene_of(MethodChoice method) {
  return {.skin = {},
          .objects = paper_objects(),
          .offset_m = method == MethodChoice::svd_knn ? 0 : 0.002,
          .noise = kNoise};
}

ChainSetup setup_of(std::size_t side, MethodChoice method) {
  ChainSetup setup{
      .layout = pad(side), .scene = scene_of(method), .estimator = {}, .alerts = {}, .friction = {}};
  setup.estimator.method = method;
  return setup;
}

std::filesystem::path folder() {
  const char* const told =
      std::getenv("SLIPD_BENCH_DIR");  // NOLINT(concurrency-mt-unsafe): before any thread
  return told != nullptr ? told : ".";
}

std::shared_ptr<const Model> model_of(const ChainSetup& setup, std::size_t contacts) {
  ModelSetup wanted = model_setup_of(setup);
  if (contacts > 0) wanted.size.contacts = contacts;
  const auto kept = folder() / "models";
  try {
    return std::make_shared<const Model>(load_cached_model(wanted, kept));
  } catch (const ModelError&) {
    const ModelData data = train(wanted);
    save_model(data, model_cache_file(wanted, kept));
    return std::make_shared<const Model>(data);
  }
}

namespace {

// Copies what comes into one block of memory.
void keep(const Frame& frame, std::size_t index, std::vector<float>& memory, std::vector<Frame>& frames) {
  const std::size_t taxels = frame.normal_pa.size();
  Frame kept = frame;
  float* to = memory.data() + 3 * taxels * index;
  for (auto* channel : {&kept.normal_pa, &kept.shear_x_pa, &kept.shear_y_pa}) {
    std::copy(channel->begin(), channel->end(), to);
    *channel = {to, taxels};
    to += taxels;
  }
  frames.push_back(kept);
}

}  // namespace

Frames::Frames(const ChainSetup& setup, std::size_t count) : memory_(3 * setup.layout.size() * count) {
  constexpr std::uint64_t kSeed = 77;  // training draws from 1
  TrialFrames maker(setup.layout, NoiseKind::relative, setup.scene.noise);
  for (std::size_t i = 0; i < count; ++i) {
    const ContactDraw draw = draw_contact(setup.scene, kSeed, i);
    const RandomStream random = RandomStream(kSeed).stream(i).stream(1);
    const double load = random.uniform(0, 0.05, 0.95) * draw.friction * draw.normal_n;
    contact::LoadHistory history(contact::make_body_pair(contact::body_of(setup.scene.skin),
                                                         {draw.radius_m, draw.modulus_pa, draw.poisson}));
    history.move_to(draw.normal_n, 0, draw.friction);
    history.move_to(draw.normal_n, load, draw.friction);
    maker.sense(history, draw.x_m, draw.y_m);
    const auto number = static_cast<std::int64_t>(i) + 1;
    keep(maker.sense(2 * std::numbers::pi * random.uniform(1), random, i + 1, 1'000'000 * number), i, memory_,
         frames_);
  }
}

namespace {
constexpr double kLeastForce_n = 1, kMostForce_n = 3, kMostLoad = 0.8;  // the last: 1 - Gamma
}

Grasp::Grasp(std::size_t side, std::size_t count) : memory_(3 * side * side * count) {
  sim::SensorSettings settings;
  settings.imperfections.noise = 0.02;
  // Ends as it began, so that it goes on for ever as one grasp: a load that came from nowhere would be a
  // fault of the sensor.
  sim::Phase press, load, unload, ease;
  for (sim::Phase* const phase : {&press, &load, &unload, &ease}) {
    phase->duration_ns = static_cast<std::int64_t>(count) * 250'000;
    phase->normal_n = sim::Ramp{kMostForce_n, kMostForce_n};
    phase->friction = 0.5;
  }
  press.normal_n = sim::Ramp{kLeastForce_n, kMostForce_n};
  ease.normal_n = sim::Ramp{kMostForce_n, kLeastForce_n};
  load.load = sim::Ramp{0, kMostLoad};
  unload.load = sim::Ramp{kMostLoad, 0};
  settings.cycle = {press, load, unload, ease};
  sim::SimulatedSensor sensor(pad(side), settings);
  std::vector<float> one(3 * side * side);
  const std::span all(one);
  FrameSlot slot;
  slot.normal_pa = all.first(side * side);
  slot.shear_x_pa = all.subspan(side * side, side * side);
  slot.shear_y_pa = all.last(side * side);
  while (frames_.size() < count) {
    sensor.advance(std::chrono::milliseconds(1));
    if (sensor.sample(slot)) keep(slot.view(), frames_.size(), memory_, frames_);
  }
}

const Frame& Grasp::next() noexcept {
  const std::uint64_t sequence = now_.sequence + 1;
  now_ = frames_[at_ = (at_ + 1) % frames_.size()];
  now_.sequence = sequence;
  now_.time_ns = static_cast<std::int64_t>(sequence) * 1'000'000;
  return now_;
}

}  // namespace slipd::bench
