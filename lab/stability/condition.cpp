#include "lab/stability/condition.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "core/patch/patch.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "lab/cramer_rao_bound.hpp"
#include "paper/method/svd_knn.hpp"
#include "paper/train.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kSmall = 1e-3;  // half-width: linear, and still far above what a float rounds

std::shared_ptr<const Model> model_of(const TrialSetup& setup, View view, int rank) {
  const ModelSetup wanted{.layout = layout_of(setup),
                          .scene = scene_of(setup),
                          .size = view == View::rings ? DataSetSize{} : kUnseenFirst,
                          .seed = setup.seed,
                          .rank = rank,
                          .neighbours = 5,
                          .view = view};
  return std::make_shared<const Model>(train(wanted, setup.threads));
}

contact::LoadHistory loaded(const Scene& scene, const ContactDraw& draw, double gamma) {
  contact::LoadHistory contact(
      contact::make_body_pair(contact::body_of(scene.skin), {draw.radius_m, draw.modulus_pa, draw.poisson}));
  contact.move_to(draw.normal_n, 0, draw.friction);
  contact.move_to(draw.normal_n, (1 - gamma) * draw.friction * draw.normal_n, draw.friction);
  return contact;
}

std::optional<double> margin_in_model(SlipMethod& method, PatchFinder& finder, const Frame& frame) {
  const ContactPatch& patch = finder.find(frame);
  if (!patch.in_contact) return {};
  const Reading reading = method.estimate(frame, patch);
  if (!reading.in_model) return {};
  return reading.gamma;
}

float rounded(float value, int bits) {
  int exponent = 0;
  const float part = std::frexp(value, &exponent);
  return std::ldexp(std::nearbyint(std::ldexp(part, bits)), exponent - bits);
}

}  // namespace

std::vector<NamedMethod> untrained_methods(const TrialSetup& setup) {
  const TaxelLayout layout = layout_of(setup);
  std::vector<NamedMethod> methods;
  methods.push_back({"moments", std::make_unique<Moments>(layout)});
  methods.push_back({"fit", make_fit(layout, {0.1, 0.9})});
  return methods;
}

std::vector<NamedMethod> all_methods(const TrialSetup& setup) {
  auto methods = untrained_methods(setup);
  methods.push_back({"registered", std::make_unique<SvdKnn>(model_of(setup, View::rings, 3))});
  methods.push_back({"svd-knn", std::make_unique<SvdKnn>(model_of(setup, View::grid, 8))});
  return methods;
}

std::vector<Condition> condition_of(const TrialSetup& setup, std::vector<NamedMethod>& methods,
                                    const Done& done) {
  const TaxelLayout layout = layout_of(setup);
  const Scene scene = scene_of(setup);
  PatchFinder finder(layout);
  TrialFrames clean(layout, setup.kind, 0), noisy(layout, setup.kind, kSmall);
  std::vector<Condition> rows;
  const auto gammas = {0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95, 0.98, 0.99};
  for (const double gamma : gammas) {
    std::vector<double> squares(methods.size(), 0), counts(methods.size(), 0);
    double limit = 0;
    for (std::size_t i = 0; i < setup.contacts; ++i) {
      const ContactDraw draw = draw_contact(scene, setup.seed, i);
      const RandomStream random = RandomStream(setup.seed).stream(i);
      const auto contact = loaded(scene, draw, gamma);
      limit += std::pow(cramer_rao_sigma(layout, contact.pair(), draw, gamma, setup.kind, kSmall), 2);
      const double direction_rad = 2 * std::numbers::pi * random.uniform(0);
      clean.sense(contact, draw.x_m, draw.y_m);
      noisy.sense(contact, draw.x_m, draw.y_m);
      const Frame without = clean.sense(direction_rad, random), with = noisy.sense(direction_rad, random);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        const auto first = margin_in_model(*methods[m].method, finder, without),
                   second = margin_in_model(*methods[m].method, finder, with);
        if (!first || !second) continue;
        squares[m] += (*second - *first) * (*second - *first);
        counts[m] += 1;
      }
    }
    Condition row{gamma, {}, 0};
    const double in = kSmall / std::numbers::sqrt3;
    row.limit = std::sqrt(limit / static_cast<double>(setup.contacts)) / in;
    for (std::size_t m = 0; m < methods.size(); ++m)
      row.by_method.push_back(counts[m] > 0 ? std::sqrt(squares[m] / counts[m]) / in : kUnknown);
    rows.push_back(std::move(row));
    done(static_cast<double>(rows.size()) / static_cast<double>(gammas.size()));
  }
  return rows;
}

std::vector<Bits> bits_needed(const TrialSetup& setup, std::vector<NamedMethod>& methods, const Done& done) {
  const TaxelLayout layout = layout_of(setup);
  const Scene scene = scene_of(setup);
  PatchFinder finder(layout);
  TrialFrames frames(layout, setup.kind, setup.noise);
  std::vector<Bits> rows;
  for (const int bits : {4, 6, 8, 10, 12, 14, 16, 20, 23}) {
    std::vector<double> sums(methods.size(), 0), counts(methods.size(), 0);
    for (std::size_t i = 0; i < setup.contacts; ++i) {
      const ContactDraw draw = draw_contact(scene, setup.seed, i);
      const RandomStream random = RandomStream(setup.seed).stream(i);
      frames.sense(loaded(scene, draw, random.uniform(0)), draw.x_m, draw.y_m);
      const Frame whole = frames.sense(2 * std::numbers::pi * random.uniform(1), random);
      std::vector<std::optional<double>> before;
      before.reserve(methods.size());
      for (auto& method : methods) before.push_back(margin_in_model(*method.method, finder, whole));
      for (const auto& channel :
           {frames.sensed_normal_pa(), frames.sensed_shear_x_pa(), frames.sensed_shear_y_pa()}) {
        for (float& value : channel) value = rounded(value, bits);
      }
      for (std::size_t m = 0; m < methods.size(); ++m) {
        const auto after = margin_in_model(*methods[m].method, finder, whole);
        if (!before[m] || !after) continue;
        sums[m] += std::fabs(*after - *before[m]);
        counts[m] += 1;
      }
    }
    Bits row{bits, {}};
    for (std::size_t m = 0; m < methods.size(); ++m)
      row.by_method.push_back(counts[m] > 0 ? sums[m] / counts[m] : kUnknown);
    rows.push_back(std::move(row));
    done(static_cast<double>(rows.size()) / 9);
  }
  return rows;
}

}  // namespace lab
