#include "paper/dataset/ring_columns.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/contact/scene_draws.hpp"

namespace slipd {

double ring_weight(std::size_t ring, std::size_t rings) noexcept {
  const double s = (static_cast<double>(ring) + 0.5) / static_cast<double>(rings);
  return std::sqrt(2 * s * (1 - s * s));
}

Rings merged(const Rings& rings, std::size_t count) noexcept {
  Rings out;
  const std::size_t each = Rings::kCount / count;
  for (std::size_t j = 0; j < Rings::kCount; ++j) {
    out.normal_n[j / each] += rings.normal_n[j];
    out.shear_n[j / each] += rings.shear_n[j];
    out.taxels[j / each] += rings.taxels[j];
  }
  return out;
}

std::array<float, Rings::kCount> ring_angles(const Rings& rings, std::size_t count) noexcept {
  std::array<float, Rings::kCount> angles{};
  for (std::size_t j = 0; j < count; ++j) {
    if (!(rings.normal_n[j] > 0)) continue;
    angles[j] = static_cast<float>(ring_weight(j, count) * std::atan(rings.shear_n[j] / rings.normal_n[j]));
  }
  return angles;
}

RingColumns::RingColumns(TaxelLayout layout, Scene scene, std::uint64_t seed, const FrameChoice& choice,
                         std::size_t rings)
    : ContactColumns(std::move(scene), seed, choice), layout_(std::move(layout)), rings_(rings) {}

void RingColumns::fill(std::size_t first, std::size_t count, float* out) const {
  PatchFinder finder(layout_);
  const std::size_t n = layout_.size();
  const auto fraction = static_cast<float>(scene_.noise);
  std::vector<float> normal(n), shear(n), across(n, 0.0F);
  for (std::size_t j = first; j < first + count; ++j, out += rows()) {
    const ContactDraw draw = draw_contact(scene_, seed_, contact(j));
    contact::LoadHistory load(contact::make_body_pair(contact::body_of(scene_.skin),
                                                      {draw.radius_m, draw.modulus_pa, draw.poisson}));
    load.move_to(draw.normal_n, 0, draw.friction);
    load.move_to(draw.normal_n, (1 - gamma(j)) * draw.friction * draw.normal_n, draw.friction);
    contact::taxel_averages(layout_, draw.x_m, draw.y_m, load, normal, shear);
    const RandomStream random = noise(j);
    const auto most = [](const std::vector<float>& values) {
      return *std::max_element(values.begin(), values.end());
    };
    if (fraction != 0) {
      random.stream(0).add_noise(normal.data(), n, fraction * most(normal));
      random.stream(1).add_noise(shear.data(), n, fraction * most(shear));
    }
    const Frame frame{1, 1, normal, shear, across};
    const ContactPatch& patch = finder.find(frame);
    const auto angles = patch.in_contact ? ring_angles(merged(sum_rings(patch, layout_), rings_), rings_)
                                         : ring_angles({}, rings_);
    std::copy_n(angles.begin(), rings_, out);
  }
}

}  // namespace slipd
