#include "paper/validation/tradeoff.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <limits>
#include <numbers>
#include <optional>

#include "core/chain/setup/method_table.hpp"
#include "core/contact/scene_draws.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/numeric/random.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "paper/method/svd_knn.hpp"
#include "paper/validation/thread_clock.hpp"

namespace slipd {
namespace {

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

// One method's answers, frame by frame.
class Trial {
 public:
  Trial(const TaxelLayout& layout, SlipMethod& method) : method_(method), finder_(layout) {
    row_.method = to_string(method.name());
    row_.settings = method.settings();
  }

  // Another contact.
  void forget() { method_.forget(); }

  // The gripper closes.
  void observe(const Frame& frame) {
    const ContactPatch& patch = finder_.find(frame);
    if (patch.in_contact) method_.observe(frame, patch);
  }

  void face(const Frame& frame, double gamma) {
    constexpr double kSafer = 0.2;
    const double start = thread_us();
    const ContactPatch& patch = finder_.find(frame);
    const Reading reading = patch.in_contact ? method_.estimate(frame, patch) : Reading{};
    times_.push_back(thread_us() - start);

    if (!reading.in_model) return;
    const double error = std::fabs(reading.gamma - gamma);
    errors_.push_back(error);
    row_.mean_error += error;
    row_.right += slip_class(std::clamp(reading.gamma, 0.0, 1.0)) == slip_class(gamma) ? 1 : 0;
    row_.claims_safer += reading.gamma - gamma > kSafer ? 1 : 0;
    row_.within_sigma += error < reading.sigma ? 1 : 0;
    row_.within_two_sigma += error < 2 * reading.sigma ? 1 : 0;
  }

  TradeoffRow result() {
    const auto answered = static_cast<double>(errors_.size());
    for (double* share :
         {&row_.mean_error, &row_.right, &row_.within_sigma, &row_.within_two_sigma, &row_.claims_safer})
      *share /= answered;
    row_.answered = answered / static_cast<double>(times_.size());
    row_.p95_error = quantile(errors_, 0.95);
    row_.p50_us = quantile(times_, 0.5);
    row_.p99_us = quantile(times_, 0.99);
    return row_;
  }

 private:
  SlipMethod& method_;
  PatchFinder finder_;
  std::vector<double> errors_, times_;
  TradeoffRow row_;
};

}  // namespace

std::vector<TradeoffRow> measure_shape_tradeoff(const TaxelLayout& layout, const Scene& scene,
                                                const contact::ContactGeometry& geometry,
                                                std::span<SlipMethod* const> methods, NoiseKind kind,
                                                double noise, std::size_t contacts, std::uint64_t seed,
                                                int closing_frames) {
  TrialFrames frames(layout, kind, noise);
  std::deque<Trial> trials;
  for (SlipMethod* method : methods) trials.emplace_back(layout, *method);
  std::optional<contact::ContactField> sheet;
  if (!geometry.plain() || closing_frames > 0) sheet.emplace(layout, geometry);
  TrialFrames closing(layout, kind, noise);
  for (std::size_t i = 0; i < contacts; ++i) {
    const ContactDraw draw = draw_contact(scene, seed, i);
    const RandomStream random = RandomStream(seed ^ 0x7261646566666fULL).stream(i);
    const double gamma = random.uniform(0), direction_rad = 2 * std::numbers::pi * random.uniform(1);
    contact::LoadHistory contact(contact::make_body_pair(contact::body_of(scene.skin),
                                                         {draw.radius_m, draw.modulus_pa, draw.poisson}));
    contact.move_to(draw.normal_n, 0, draw.friction);
    contact.move_to(draw.normal_n, (1 - gamma) * draw.friction * draw.normal_n, draw.friction);
    Frame frame;
    if (sheet) {
      sheet->turn(std::numbers::pi * random.uniform(2));
      frame = frames.sense_field(*sheet, contact, draw.x_m, draw.y_m, direction_rad, random);
    } else {
      frames.sense(contact, draw.x_m, draw.y_m);
      frame = frames.sense(direction_rad, random);
    }
    for (Trial& trial : trials) trial.forget();
    for (int step = 1; step <= closing_frames; ++step) {
      const auto sensed = frames.normal_pa();
      const double noise_pa = noise * *std::max_element(sensed.begin(), sensed.end());
      contact::LoadHistory pressed(contact.pair());
      pressed.move_to(draw.normal_n * step / closing_frames, 0, draw.friction);
      const Frame seen = closing.sense_field(*sheet, pressed, draw.x_m, draw.y_m, 0,
                                             random.stream(static_cast<std::uint64_t>(step)), noise_pa);
      for (Trial& trial : trials) trial.observe(seen);
    }
    for (Trial& trial : trials) trial.face(frame, gamma);
  }
  std::vector<TradeoffRow> rows;
  rows.reserve(trials.size());
  for (Trial& trial : trials) rows.push_back(trial.result());
  return rows;
}

std::vector<TradeoffRow> measure_tradeoff(const TaxelLayout& layout, const Scene& scene,
                                          std::span<SlipMethod* const> methods, NoiseKind kind, double noise,
                                          std::size_t contacts, std::uint64_t seed) {
  return measure_shape_tradeoff(
      layout, scene, {.depth_m = scene.skin.depth_m, .bonded_poisson = scene.skin.bonded_poisson()}, methods,
      kind, noise, contacts, seed);
}

TradeoffRow measure_tradeoff(const TaxelLayout& layout, const Scene& scene, SlipMethod& method,
                             NoiseKind kind, double noise, std::size_t contacts, std::uint64_t seed) {
  SlipMethod* const only = &method;
  return measure_tradeoff(layout, scene, std::span(&only, 1), kind, noise, contacts, seed).front();
}

WorkPrecision measure_work_precision(const std::vector<std::shared_ptr<const Model>>& models,
                                     std::size_t contacts, std::uint64_t seed) {
  const ModelSetup& setup = models.front()->setup();
  Moments moments(setup.layout);
  const auto fit = make_fit(setup.layout, expected_friction(setup.scene));
  std::deque<SvdKnn> trained;
  for (const auto& model : models) trained.emplace_back(model);
  trained.emplace_back(models.front(), Precision::double_precision);
  std::vector<SlipMethod*> methods{&moments, fit.get()};
  std::optional<BlockFit> in_blocks;
  if (blocks_pay(setup.layout, setup.scene))
    methods.push_back(&in_blocks.emplace(setup.layout, expected_friction(setup.scene)));
  for (SvdKnn& each : trained) methods.push_back(&each);
  return {measure_tradeoff(setup.layout, setup.scene, methods, NoiseKind::relative, setup.scene.noise,
                           contacts, seed),
          processor_name()};
}

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

}  // namespace slipd
