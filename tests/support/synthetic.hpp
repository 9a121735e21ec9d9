// Frames of a known contact, for tests: the tractions of a load history averaged over taxels, rotated to a
// direction, with noise.
#pragma once

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/frame/frame.hpp"

namespace slipd::synthetic {

enum class Noise { relative, sensor };

inline contact::BodyPair paper_pair(double object_radius_m = std::numeric_limits<double>::infinity(),
                                    double object_modulus_pa = 2e11) {
  return contact::make_body_pair({0.01, 0.5e6, 0.45}, {object_radius_m, object_modulus_pa, 0.25});
}

// A contact of the data set (docs/methods.md §26.1): half of the objects flat, half of them stiff.
inline contact::BodyPair random_pair(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const bool stiff = unit(random) < 0.5, flat = unit(random) < 0.5;
  const double radius = flat ? std::numeric_limits<double>::infinity() : 0.01 + 0.04 * unit(random);
  const double modulus = stiff ? 1e11 * (1 + 2 * unit(random)) : 0.1e6 + 9.9e6 * unit(random);
  return contact::make_body_pair(
      {0.01, 0.5e6, 0.45}, {radius, modulus, stiff ? 0.2 + 0.1 * unit(random) : 0.35 + 0.1 * unit(random)});
}

class FrameMaker {
 public:
  explicit FrameMaker(TaxelLayout layout, std::uint64_t seed = 1)
      : layout_(std::move(layout)),
        random_(seed),
        normal_(layout_.size()),
        shear_(layout_.size()),
        x_(layout_.size()),
        y_(layout_.size()) {}

  // The noise's half-width is `noise` times the frame's maximum: of p on p and of q on q (relative), or of p
  // on all three channels (sensor).
  Frame make(const contact::LoadHistory& contact, double center_x_m, double center_y_m, double direction_rad,
             double noise, Noise kind = Noise::relative) {
    contact::taxel_averages(layout_, center_x_m, center_y_m, contact, normal_, shear_);
    float peak_p = 0, peak_q = 0;
    for (std::size_t i = 0; i < normal_.size(); ++i) {
      peak_p = std::max(peak_p, normal_[i]);
      peak_q = std::max(peak_q, std::fabs(shear_[i]));
    }
    const auto c = static_cast<float>(std::cos(direction_rad)),
               s = static_cast<float>(std::sin(direction_rad));
    std::uniform_real_distribution<float> unit(-1, 1);
    const auto width = static_cast<float>(noise);
    for (std::size_t i = 0; i < normal_.size(); ++i) {
      normal_[i] += width * peak_p * unit(random_);
      if (kind == Noise::relative) {
        const float q = shear_[i] + width * peak_q * unit(random_);
        x_[i] = c * q;
        y_[i] = s * q;
      } else {
        x_[i] = c * shear_[i] + width * peak_p * unit(random_);
        y_[i] = s * shear_[i] + width * peak_p * unit(random_);
      }
    }
    ++sequence_;
    return {sequence_, static_cast<std::int64_t>(sequence_) * 1000000, normal_, x_, y_};
  }

  const TaxelLayout& layout() const { return layout_; }

 private:
  TaxelLayout layout_;
  std::mt19937_64 random_;
  std::vector<float> normal_, shear_, x_, y_;
  std::uint64_t sequence_ = 0;
};

}  // namespace slipd::synthetic
