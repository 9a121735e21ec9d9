#include "paper/dataset/frame_columns.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/contact/hertz.hpp"
#include "core/contact/scene_draws.hpp"
#include "core/contact/subsurface/dome_averages.hpp"
#include "core/numeric/random.hpp"
#include "paper/dataset/alpha.hpp"

namespace slipd {
namespace {

// One contact on the taxels that it touches. Off them nothing is computed: noise never passes the mask there.
class Touched {
 public:
  Touched(const TaxelSet& taxels, const ContactDraw& draw, double radius_m) : side_m_(taxels.side_m) {
    const double reach = radius_m + 0.7072 * side_m_;
    for (std::size_t i = 0; i < taxels.size(); ++i) {
      const double u = taxels.x_m[i] - draw.x_m, v = taxels.y_m[i] - draw.y_m;
      if (u * u + v * v >= reach * reach) continue;
      taxel.push_back(i);
      u_m_.push_back(u);
      v_m_.push_back(v);
    }
  }

  // sqrt(radius² - r²) averaged over each taxel, in m.
  void averages(double radius_m, std::vector<double>& out) const {
    out.resize(taxel.size());
    contact::average_dome(radius_m, side_m_, u_m_, v_m_, out);
  }

  std::vector<std::size_t> taxel;

 private:
  double side_m_;
  std::vector<double> u_m_, v_m_;
};

float largest_of(const std::vector<float>& values) noexcept {
  return values.empty() ? 0.0F : *std::max_element(values.begin(), values.end());
}

}  // namespace

FrameColumns::FrameColumns(TaxelSet taxels, Scene scene, std::uint64_t seed, const FrameChoice& choice)
    : ContactColumns(std::move(scene), seed, choice), taxels_(std::move(taxels)) {
  if (!taxels_.weight.empty() && (scene_.noise != 0 || scene_.offset_m != 0)) {
    throw std::invalid_argument(
        "only contacts in the middle and without noise are the same on folded taxels");
  }
}

void FrameColumns::fill(std::size_t first, std::size_t count, float* out) const {
  const std::size_t n = rows();
  const auto fraction = static_cast<float>(scene_.noise);
  std::vector<double> whole, stick;
  std::vector<float> normal, shear, across, angle;
  std::optional<Touched> touched;
  ContactDraw draw;
  contact::BodyPair pair;
  double radius_m = 0;
  for (std::size_t j = first; j < first + count; ++j, out += n) {
    if (j == first || j % choice_.size.loads == 0) {
      draw = draw_contact(scene_, seed_, contact(j));
      pair = contact::make_body_pair(contact::body_of(scene_.skin),
                                     {draw.radius_m, draw.modulus_pa, draw.poisson});
      radius_m = pair.contact_radius_m(draw.normal_n);
      touched.emplace(taxels_, draw, radius_m);
      touched->averages(radius_m, whole);
    }
    // docs/theory.md §3.1: q = mu (D_a - D_c), c = a cbrt(Gamma).
    const double margin = gamma(j), scale = pair.disc_scale_pa_per_m();
    touched->averages(radius_m * std::cbrt(margin), stick);
    const std::size_t size = whole.size();
    normal.resize(size);
    shear.resize(size);
    across.assign(size, 0.0F);
    angle.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      normal[i] = static_cast<float>(scale * whole[i]);
      shear[i] = margin < 1 ? static_cast<float>(scale * draw.friction * (whole[i] - stick[i])) : 0.0F;
    }
    if (fraction != 0) {
      const RandomStream random = noise(j);
      random.stream(0).add_noise(normal.data(), size, fraction * largest_of(normal));
      random.stream(1).add_noise(shear.data(), size, fraction * largest_of(shear));
    }
    alpha_of(normal, shear, across, {.least_pa = mask_fraction(scene_.noise) * largest_of(normal)}, angle);
    std::fill_n(out, n, 0.0F);
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t taxel = touched->taxel[i];
      out[taxel] = taxels_.weight.empty() ? angle[i] : angle[i] * taxels_.weight[taxel];
    }
  }
}

}  // namespace slipd
