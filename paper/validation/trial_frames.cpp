#include "paper/validation/trial_frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/contact/averages.hpp"

namespace slipd {

TrialFrames::TrialFrames(const TaxelLayout& layout, NoiseKind kind, double noise)
    : layout_(layout),
      kind_(kind),
      noise_(static_cast<float>(noise)),
      normal_(layout.size()),
      shear_(layout.size()),
      noisy_(layout.size()),
      x_(layout.size()),
      y_(layout.size()) {}

void TrialFrames::sense(const contact::LoadHistory& contact, double center_x_m, double center_y_m) {
  if (layout_.size() == 1) {
    normal_[0] = static_cast<float>(contact.normal_n() / layout_.area_m2());
    shear_[0] = static_cast<float>(contact.shear_n() / layout_.area_m2());
    return;
  }
  contact::taxel_averages(layout_, center_x_m, center_y_m, contact, normal_, shear_);
}

Frame TrialFrames::sense_field(contact::ContactField& geometry, const contact::LoadHistory& contact,
                               double center_x_m, double center_y_m, double direction_rad,
                               const RandomStream& random, std::optional<double> noise_pa) {
  geometry.sense(contact, center_x_m, center_y_m, direction_rad, normal_, x_, y_);
  return sense_plane(random, noise_pa);
}

Frame TrialFrames::sense_plane(const RandomStream& random, std::optional<double> noise_pa) {
  float most_p = 0, most_q = 0;
  for (std::size_t i = 0; i < normal_.size(); ++i) {
    most_p = std::max(most_p, normal_[i]);
    most_q = std::max(most_q, std::hypot(x_[i], y_[i]));
  }
  const auto half_width = [&](float most) {
    return noise_pa ? static_cast<float>(*noise_pa) : noise_ * most;
  };
  const float of_shear = half_width(kind_ == NoiseKind::sensor ? most_p : most_q);
  noisy_ = normal_;
  random.stream(0).add_noise(noisy_.data(), noisy_.size(), half_width(most_p));
  random.stream(1).add_noise(x_.data(), x_.size(), of_shear);
  random.stream(2).add_noise(y_.data(), y_.size(), of_shear);
  return {1, 1, noisy_, x_, y_};
}

Frame TrialFrames::sense(double direction_rad, const RandomStream& random, std::uint64_t sequence,
                         std::int64_t time_ns) {
  float most_p = 0, most_q = 0;
  for (std::size_t i = 0; i < normal_.size(); ++i) {
    most_p = std::max(most_p, normal_[i]);
    most_q = std::max(most_q, std::fabs(shear_[i]));
  }
  const auto n = normal_.size();
  noisy_ = normal_;
  random.stream(0).add_noise(noisy_.data(), n, noise_ * most_p);
  const auto c = static_cast<float>(std::cos(direction_rad)), s = static_cast<float>(std::sin(direction_rad));
  x_ = shear_;
  if (kind_ == NoiseKind::relative) random.stream(1).add_noise(x_.data(), n, noise_ * most_q);
  for (std::size_t i = 0; i < n; ++i) {
    y_[i] = s * x_[i];
    x_[i] *= c;
  }
  if (kind_ == NoiseKind::sensor) {
    random.stream(1).add_noise(x_.data(), n, noise_ * most_p);
    random.stream(2).add_noise(y_.data(), n, noise_ * most_p);
  }
  return {sequence, time_ns, noisy_, x_, y_};
}

}  // namespace slipd
