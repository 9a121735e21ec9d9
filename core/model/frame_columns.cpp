#include "core/model/frame_columns.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/model/alpha.hpp"
#include "core/model/random.hpp"

namespace slipd {
namespace {

// Streams that no contact has: contacts are counted from 0.
constexpr std::uint64_t kNoiseStream = ~std::uint64_t{1};
constexpr std::uint64_t kLoadStream = ~std::uint64_t{2};

// sqrt(radius² - r²) averaged over each taxel, in m; 0 where the disc does not reach.
void disc_averages(const TaxelSet& taxels, const ContactDraw& draw, double radius_m,
                   std::vector<double>& averages) {
  for (std::size_t i = 0; i < taxels.size(); ++i) {
    averages[i] =
        contact::disc_average(radius_m, taxels.x_m[i] - draw.x_m, taxels.y_m[i] - draw.y_m, taxels.side_m);
  }
}

float largest_of(const std::vector<float>& values) noexcept {
  return *std::max_element(values.begin(), values.end());
}

}  // namespace

FrameColumns::FrameColumns(TaxelSet taxels, Scene scene, std::uint64_t seed, FrameChoice choice)
    : taxels_(std::move(taxels)), scene_(std::move(scene)), seed_(seed), choice_(choice) {
  if (!taxels_.weight.empty() && (scene_.noise != 0 || scene_.offset_m != 0)) {
    throw std::invalid_argument(
        "only contacts in the middle and without noise are the same on folded taxels");
  }
}

double FrameColumns::gamma(std::size_t column) const {
  const std::size_t step = column % choice_.size.loads;
  if (!choice_.random_loads) return gamma_of_step(step, choice_.size.loads);
  return Draws(seed_).stream(kLoadStream).stream(contact(column)).uniform(step);
}

double FrameColumns::friction(std::size_t column) const {
  return draw_contact(scene_, seed_, contact(column)).friction;
}

void FrameColumns::fill(std::size_t first, std::size_t count, float* out) const {
  const std::size_t n = rows();
  std::vector<double> whole(n), stick(n);
  std::vector<float> normal(n), shear(n), across(n, 0.0F);
  ContactDraw draw;
  contact::Pair pair;
  double radius_m = 0;
  for (std::size_t j = first; j < first + count; ++j, out += n) {
    if (j == first || j % choice_.size.loads == 0) {
      draw = draw_contact(scene_, seed_, contact(j));
      pair =
          contact::make_pair(contact::body_of(scene_.skin), {draw.radius_m, draw.modulus_pa, draw.poisson});
      radius_m = pair.contact_radius_m(draw.normal_n);
      disc_averages(taxels_, draw, radius_m, whole);
    }
    // Cattaneo and Mindlin: q = mu (D_a - D_c), c = a cbrt(Gamma).
    const double margin = gamma(j);
    disc_averages(taxels_, draw, radius_m * std::cbrt(margin), stick);
    const double scale = pair.disc_scale_pa_per_m();
    for (std::size_t i = 0; i < n; ++i) {
      normal[i] = static_cast<float>(scale * whole[i]);
      shear[i] = margin < 1 ? static_cast<float>(scale * draw.friction * (whole[i] - stick[i])) : 0.0F;
    }
    if (scene_.noise != 0) {
      const auto fraction = static_cast<float>(scene_.noise);
      const Draws noise = Draws(seed_).stream(kNoiseStream).stream(contact(j)).stream(j % choice_.size.loads);
      const float on_normal = fraction * largest_of(normal), on_shear = fraction * largest_of(shear);
      noise.stream(0).add_noise(normal.data(), n, on_normal);
      noise.stream(1).add_noise(shear.data(), n, on_shear);
    }
    const AlphaMask mask{.least_pa = mask_fraction(scene_.noise) * largest_of(normal)};
    alpha_of(normal, shear, across, mask, {out, n});
    for (std::size_t i = 0; i < taxels_.weight.size(); ++i) out[i] *= taxels_.weight[i];
  }
}

}  // namespace slipd
