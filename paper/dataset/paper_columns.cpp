#include "paper/dataset/paper_columns.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/contact/cattaneo_mindlin.hpp"
#include "core/contact/scene_draws.hpp"
#include "core/numeric/random.hpp"
#include "paper/dataset/alpha.hpp"

namespace slipd {
namespace {

// One contact, laid on the taxels: which of them it touches, and where in it they are.
struct Placed {
  std::vector<std::size_t> taxel;
  std::vector<double> s;  // r/a, < 1
};

Placed place(const TaxelSet& taxels, const ContactDraw& draw, double radius_m) {
  Placed placed;
  for (std::size_t i = 0; i < taxels.size(); ++i) {
    const double s = std::hypot(taxels.x_m[i] - draw.x_m, taxels.y_m[i] - draw.y_m) / radius_m;
    if (s < 1) {
      placed.taxel.push_back(i);
      placed.s.push_back(s);
    }
  }
  return placed;
}

}  // namespace

PaperColumns::PaperColumns(TaxelSet taxels, Scene scene, DataSetSize size, std::uint64_t seed,
                           Quantity quantity)
    : taxels_(std::move(taxels)), scene_(std::move(scene)), size_(size), seed_(seed), quantity_(quantity) {
  if (!taxels_.weight.empty() && (scene_.noise != 0 || scene_.offset_m != 0)) {
    throw std::invalid_argument(
        "only contacts in the middle and without noise are the same on folded taxels");
  }
}

void PaperColumns::fill(std::size_t first, std::size_t count, float* out) const {
  const std::size_t n = rows();
  std::vector<float> values, angles;
  Placed placed;
  ContactDraw draw;
  contact::BodyPair pair;
  for (std::size_t j = first; j < first + count; ++j, out += n) {
    if (j == first || j % size_.loads == 0) {
      draw = draw_contact(scene_, seed_, contact(j));
      pair = contact::make_body_pair(contact::body_of(scene_.skin),
                                     {draw.radius_m, draw.modulus_pa, draw.poisson});
      placed = place(taxels_, draw, pair.contact_radius_m(draw.normal_n));
    }
    const contact::CattaneoMindlin load(pair, draw.normal_n, draw.friction, 1 - gamma(j));
    const std::size_t touched = placed.taxel.size();
    values.resize(touched);
    for (std::size_t i = 0; i < touched; ++i) {
      const double s = placed.s[i];
      const double ratio = quantity_ == Quantity::pressure ? 1 : draw.friction * load.mobilised_friction(s);
      const double pressure =
          quantity_ == Quantity::alpha ? 1 : load.peak_pressure_pa() * std::sqrt((1 - s) * (1 + s));
      values[i] = static_cast<float>(ratio * pressure);
    }
    if (quantity_ == Quantity::alpha) {
      angles.resize(touched);
      alpha_of_ratio(values, angles);
      values.swap(angles);
    }
    std::fill_n(out, n, 0.0F);
    float largest = 0;
    for (std::size_t i = 0; i < touched; ++i) {
      const std::size_t taxel = placed.taxel[i];
      largest = std::max(largest, values[i]);
      out[taxel] = taxels_.weight.empty() ? values[i] : values[i] * taxels_.weight[taxel];
    }
    if (scene_.noise != 0) {
      // A stream that no contact has: contacts are counted from 0.
      const RandomStream noise = RandomStream(seed_).stream(~std::uint64_t{0}).stream(j);
      noise.add_noise(out, n, static_cast<float>(scene_.noise) * largest);
    }
  }
}

}  // namespace slipd
