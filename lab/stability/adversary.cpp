#include "lab/stability/adversary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/numeric/random.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr std::size_t kFine = 5;  // points along each side of a taxel

TaxelLayout finer(const TaxelLayout& layout) {
  const auto& grid = layout.regular().value();
  return TaxelLayout::grid(kFine * grid.columns, kFine * grid.rows, grid.pitch_m / kFine);
}

}  // namespace

std::string_view name_of(Perturbation perturbation) noexcept {
  static constexpr std::array<std::string_view, kPerturbations> kNames{
      "blurred", "elliptic", "tilted", "gains", "dead", "biased", "cut", "regripped", "unloaded", "grown"};
  return kNames[static_cast<std::size_t>(perturbation)];
}

std::string_view strength_of(Perturbation perturbation) noexcept {
  static constexpr std::array<std::string_view, kPerturbations> kStrengths{
      "depth of the skin layer, mm", "long over short axis",    "skew of the pressure",
      "spread of the gains",         "share of taxels dead",    "zero of shear, of the largest p",
      "off the middle, mm",          "P raised by, at equal Q", "Q fallen by",
      "share that came together"};
  return kStrengths[static_cast<std::size_t>(perturbation)];
}

std::vector<double> strengths(Perturbation perturbation) {
  switch (perturbation) {
    case Perturbation::blurred:
      return {0, 0.25, 0.5, 1, 1.5, 2};
    case Perturbation::elliptic:
      return {1, 1.05, 1.1, 1.25, 1.5, 2};
    case Perturbation::tilted:
      return {0, 0.05, 0.1, 0.2, 0.3, 0.5};
    case Perturbation::gains:
      return {0, 0.02, 0.05, 0.1, 0.2, 0.3};
    case Perturbation::dead:
      return {0, 0.01, 0.02, 0.05, 0.1, 0.2};
    case Perturbation::biased:
      return {0, 0.002, 0.005, 0.01, 0.02, 0.05};
    case Perturbation::cut:
      return {0, 2, 4, 6, 8, 9};
    case Perturbation::regripped:
      return {0, 0.05, 0.1, 0.25, 0.5, 1};
    case Perturbation::unloaded:
      return {0, 0.05, 0.1, 0.25, 0.5, 1.5};
    case Perturbation::grown:
      return {0, 0.1, 0.25, 0.5, 0.75, 0.95};
  }
  return {};
}

Adversary::Adversary(const TaxelLayout& layout, NoiseKind kind, double noise)
    : layout_(layout),
      fine_(finer(layout)),
      frames_(layout_, kind, noise),
      p_(fine_.size()),
      q_(fine_.size()),
      row_(fine_.size()),
      sum_(fine_.size()),
      part_(fine_.size()) {}

// A Gaussian filter along the rows, then along the columns; the stress beyond the pad counts as 0.
void Adversary::blur(std::vector<float>& field, double sigma_m) {
  const auto& grid = fine_.regular().value();
  const double sigma = sigma_m / grid.pitch_m;
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3.5 * sigma));
  std::vector<float> weight(static_cast<std::size_t>(reach) + 1);
  double all = 0;
  for (std::ptrdiff_t d = 0; d <= reach; ++d) {
    const double w = std::exp(-0.5 * static_cast<double>(d * d) / (sigma * sigma));
    weight[static_cast<std::size_t>(d)] = static_cast<float>(w);
    all += d == 0 ? w : 2 * w;
  }
  for (float& w : weight) w /= static_cast<float>(all);
  const auto along = [&](const std::vector<float>& from, std::vector<float>& to, std::ptrdiff_t step,
                         std::ptrdiff_t count) {
    std::fill(to.begin(), to.end(), 0.0F);
    const auto size = static_cast<std::ptrdiff_t>(from.size());
    for (std::ptrdiff_t d = -reach; d <= reach; ++d) {
      const float w = weight[static_cast<std::size_t>(std::abs(d))];
      if (step != 1) {  // whole rows move
        const std::ptrdiff_t shift = d * step, first = std::max<std::ptrdiff_t>(0, -shift),
                             end = std::min(size, size - shift);
        for (std::ptrdiff_t i = first; i < end; ++i)
          to[static_cast<std::size_t>(i)] += w * from[static_cast<std::size_t>(i + shift)];
        continue;
      }
      const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -d), end = std::min(count, count - d);
      for (std::ptrdiff_t line = 0; line < size; line += count) {
        for (std::ptrdiff_t i = line + first; i < line + end; ++i)
          to[static_cast<std::size_t>(i)] += w * from[static_cast<std::size_t>(i + d)];
      }
    }
  };
  const auto columns = static_cast<std::ptrdiff_t>(grid.columns);
  along(field, row_, 1, columns);
  along(row_, field, columns, columns);
}

// Boussinesq's 3 z^3 / (2 pi (r^2 + z^2)^(5/2)) is a mixture of Gaussians whose 1/sigma^2, in units of 1/z^2,
// is distributed as chi-squared with three degrees of freedom; four of equal weight stand for it.
void Adversary::blur_by_layer(std::vector<float>& field, double depth_m) {
  std::fill(sum_.begin(), sum_.end(), 0.0F);
  for (const double quantile : {0.692, 1.753, 3.106, 5.739}) {
    part_ = field;
    blur(part_, depth_m / std::sqrt(quantile));
    for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i] += 0.25F * part_[i];
  }
  field = sum_;
}

// Computes tractions point by point and averages them over the taxels. Returns the remaining share of Q.
double Adversary::sense(Perturbation perturbation, double strength, const contact::LoadHistory& contact,
                        const ContactDraw& at, double turn_rad) {
  const double c = std::cos(turn_rad), s = std::sin(turn_rad), a = contact.contact_radius_m();
  const double stretch = perturbation == Perturbation::elliptic ? std::sqrt(strength) : 1;
  double whole = 0, left = 0;
  for (std::size_t i = 0; i < fine_.size(); ++i) {
    const double x = fine_.x_m()[i] - at.x_m, y = fine_.y_m()[i] - at.y_m;
    const double u = (c * x + s * y) / stretch, v = (c * y - s * x) * stretch, r = std::hypot(u, v);
    double p = contact.pressure_pa(r), q = contact.shear_pa(r);
    whole += q;
    if (perturbation == Perturbation::tilted) {
      p *= 1 + strength * u / a;
      q = std::min(q, contact.friction() * p);
    }
    left += q;
    p_[i] = static_cast<float>(p);
    q_[i] = static_cast<float>(q);
  }
  if (perturbation == Perturbation::blurred) {
    blur_by_layer(p_, 1e-3 * strength);
    blur_by_layer(q_, 1e-3 * strength);
  }
  const auto& grid = layout_.regular().value();
  const auto normal = frames_.normal_pa(), shear = frames_.shear_pa();
  for (std::size_t taxel = 0; taxel < layout_.size(); ++taxel) {
    const std::size_t row = kFine * (taxel / grid.columns), column = kFine * (taxel % grid.columns);
    float p = 0, q = 0;
    for (std::size_t j = 0; j < kFine * kFine; ++j) {
      const std::size_t i = (row + j / kFine) * kFine * grid.columns + column + j % kFine;
      p += p_[i];
      q += q_[i];
    }
    normal[taxel] = p / (kFine * kFine);
    shear[taxel] = q / (kFine * kFine);
  }
  return whole > 0 ? left / whole : 1;
}

Trial Adversary::make(Perturbation perturbation, double strength, const Scene& scene, std::uint64_t seed,
                      std::size_t index) {
  ContactDraw draw = draw_contact(scene, seed, index);
  const RandomStream random = RandomStream(seed ^ 0x666c6177ULL).stream(index);
  const double load = 1 - random.uniform(0), direction_rad = 2 * std::numbers::pi * random.uniform(1),
               turn_rad = 2 * std::numbers::pi * random.uniform(2);
  const double normal_n = draw.normal_n, mu = draw.friction, shear_n = load * mu * normal_n;
  contact::LoadHistory contact(
      contact::make_body_pair(contact::body_of(scene.skin), {draw.radius_m, draw.modulus_pa, draw.poisson}));
  const double alone =
      perturbation == Perturbation::grown ? 1 - strength : 1;  // of the load, what rose by itself
  contact.move_to(alone * normal_n, 0, mu);
  contact.move_to(alone * normal_n, alone * shear_n, mu);
  if (perturbation == Perturbation::grown && strength > 0) contact.move_to(normal_n, shear_n, mu);
  if (perturbation == Perturbation::regripped) contact.move_to((1 + strength) * normal_n, shear_n, mu);
  if (perturbation == Perturbation::unloaded) contact.move_to(normal_n, (1 - strength) * shear_n, mu);
  if (perturbation == Perturbation::cut) {
    draw.x_m = 1e-3 * strength * std::cos(turn_rad);
    draw.y_m = 1e-3 * strength * std::sin(turn_rad);
  }
  double kept = 1;
  const bool shaped = perturbation == Perturbation::elliptic ? strength != 1 : strength != 0;
  if (shaped && (perturbation == Perturbation::blurred || perturbation == Perturbation::elliptic ||
                 perturbation == Perturbation::tilted)) {
    kept = sense(perturbation, strength, contact, draw, turn_rad);
  } else {
    frames_.sense(contact, draw.x_m, draw.y_m);
  }
  const RandomStream taxels = random.stream(3);
  if (perturbation == Perturbation::gains) {
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      const auto gain = static_cast<float>(1 + strength * static_cast<double>(taxels.noise(i)));
      frames_.normal_pa()[i] *= gain;
      frames_.shear_pa()[i] *= gain;
    }
  }
  const auto normal = frames_.normal_pa();
  const float peak_pa = *std::max_element(normal.begin(), normal.end());
  const Frame frame = frames_.sense(direction_rad, random.stream(4));
  const auto p = frames_.sensed_normal_pa(), x = frames_.sensed_shear_x_pa(), y = frames_.sensed_shear_y_pa();
  for (std::size_t i = 0; i < layout_.size(); ++i) {
    if (perturbation == Perturbation::biased) {
      x[i] += static_cast<float>(strength * std::cos(turn_rad)) * peak_pa;
      y[i] += static_cast<float>(strength * std::sin(turn_rad)) * peak_pa;
    }
    if (perturbation == Perturbation::dead && taxels.uniform(i) < strength) p[i] = x[i] = y[i] = 0;
  }
  return {frame, 1 - kept * (1 - contact.safety_margin())};
}

}  // namespace lab
