#include "core/estimate/tradeoff.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include "core/estimate/fit.hpp"
#include "core/estimate/moments.hpp"
#include "core/estimate/svd_knn.hpp"
#include "core/estimate/thread_clock.hpp"
#include "core/model/dataset.hpp"
#include "core/model/random.hpp"

namespace slipd {
namespace {

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

TradeoffRow measure_tradeoff(const TaxelLayout& layout, const Scene& scene, SlipMethod& method,
                             NoiseKind kind, double noise, std::size_t contacts, std::uint64_t seed) {
  PatchFinder finder(layout);
  TrialFrames frames(layout, kind, noise);
  std::vector<double> errors, times;
  TradeoffRow row;
  row.method = to_string(method.name());
  row.settings = method.settings();
  for (std::size_t i = 0; i < contacts; ++i) {
    const ContactDraw draw = draw_contact(scene, seed, i);
    const Draws random = Draws(seed ^ 0x7261646566666fULL).stream(i);
    const double gamma = random.uniform(0);
    contact::LoadHistory contact(
        contact::make_pair(contact::body_of(scene.skin), {draw.radius_m, draw.modulus_pa, draw.poisson}));
    contact.move_to(draw.normal_n, 0, draw.friction);
    contact.move_to(draw.normal_n, (1 - gamma) * draw.friction * draw.normal_n, draw.friction);
    frames.feel(contact, draw.x_m, draw.y_m);
    const Frame frame = frames.sense(2 * std::numbers::pi * random.uniform(1), random);

    const double start = thread_us();
    const ContactPatch& patch = finder.find(frame);
    const Reading reading = patch.touched ? method.read(frame, patch) : Reading{};
    times.push_back(thread_us() - start);

    if (!reading.in_family) continue;
    const double error = std::fabs(reading.gamma - gamma);
    errors.push_back(error);
    row.mean_error += error;
    row.right += slip_class(std::clamp(reading.gamma, 0.0, 1.0)) == slip_class(gamma) ? 1 : 0;
    row.within_sigma += error < reading.sigma ? 1 : 0;
    row.within_two_sigma += error < 2 * reading.sigma ? 1 : 0;
  }
  const auto answered = static_cast<double>(errors.size());
  for (double* share : {&row.mean_error, &row.right, &row.within_sigma, &row.within_two_sigma})
    *share /= answered;
  row.answered = answered / static_cast<double>(contacts);
  row.p95_error = quantile(errors, 0.95);
  row.p50_us = quantile(times, 0.5);
  row.p99_us = quantile(times, 0.99);
  return row;
}

Worth measure_worth(const std::vector<std::shared_ptr<const Model>>& models, std::size_t contacts,
                    std::uint64_t seed) {
  const ModelSetup& setup = models.front()->setup();
  Worth worth{{}, processor_name()};
  const auto add = [&](SlipMethod& method) {
    worth.rows.push_back(measure_tradeoff(setup.layout, setup.scene, method, NoiseKind::relative,
                                          setup.scene.noise, contacts, seed));
  };
  Moments moments(setup.layout);
  add(moments);
  Fit fit(setup.layout, expected_friction(setup.scene));
  add(fit);
  for (const auto& model : models) {
    SvdKnn knn(model);
    add(knn);
  }
  SvdKnn twice(models.front(), Precision::double_precision);
  add(twice);
  return worth;
}

Worth measure_worth(const ChainSetup& setup, Method method) {
  constexpr std::size_t kContacts = 48;
  constexpr std::uint64_t kSeed = 2;  // training draws from 1
  if (setup.layout.size() <= Fit::kFewTaxels) return {};
  Scene scene = setup.scene;
  if (scene.objects.empty()) scene.objects = paper_objects();
  const auto measured = [&](SlipMethod&& with) -> Worth {
    return {{measure_tradeoff(setup.layout, scene, with, NoiseKind::relative, scene.noise, kContacts, kSeed)},
            processor_name()};
  };
  if (method == Method::moments) return measured(Moments(setup.layout));
  if (method == Method::fit) return measured(Fit(setup.layout, expected_friction(setup.scene)));
  return {};
}

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

Range expected_friction(const Scene& scene) {
  Range all{0.1, 0.9};
  if (!scene.objects.empty()) all = scene.objects.front().friction;
  for (const auto& family : scene.objects) {
    all = {std::min(all.low, family.friction.low), std::max(all.high, family.friction.high)};
  }
  return all;
}

std::size_t choose(std::span<const TradeoffRow> rows, double budget_us) {
  // One that is silent on much of its scene is not better for being right on the rest.
  const auto cost = [](const TradeoffRow& row) {
    return std::isfinite(row.mean_error) ? row.mean_error + 0.25 * (1 - row.answered) : 1.0;
  };
  std::size_t best = rows.size(), fastest = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].p50_us < rows[fastest].p50_us) fastest = i;
    if (rows[i].p50_us <= budget_us && (best == rows.size() || cost(rows[i]) < cost(rows[best]))) best = i;
  }
  return best == rows.size() ? fastest : best;
}

}  // namespace slipd
