// Frames of a contact that carries a force and a torque, for tests: a Hertz pressure on a bed of springs that
// is shifted and turned; each spring sticks, or slips at friction times its pressure. No half space, but
// where it slips it is exact, and a contact that slides all over is one of any body.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd::synthetic {

struct Turned {
  double center_x_m = 0, center_y_m = 0;
  double radius_m = 4e-3;
  double peak_pa = 60e3;
  double friction = 0.5;
  double shift_x = 0, shift_y = 0;  // of the springs' give at the peak: 1 slips there
  double turn = 0;                  // the same at one radius from the centre
  double noise = 0;                 // half-width, of the peak, on all channels
};

class TurningFrames {
 public:
  explicit TurningFrames(TaxelLayout layout, std::uint64_t seed = 1)
      : layout_(std::move(layout)),
        random_(seed),
        normal_(layout_.size()),
        x_(layout_.size()),
        y_(layout_.size()) {}

  Frame make(const Turned& contact) {
    const double side = layout_.side_m(), a = contact.radius_m;
    shear_x_n_ = shear_y_n_ = torque_nm_ = normal_n_ = 0;
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      double p = 0, qx = 0, qy = 0;
      constexpr int kParts = 4;
      for (int part = 0; part < kParts * kParts; ++part) {
        const double u =
            layout_.x_m()[i] - contact.center_x_m + ((part % kParts + 0.5) / kParts - 0.5) * side;
        const double v =
            layout_.y_m()[i] - contact.center_y_m + ((part / kParts + 0.5) / kParts - 0.5) * side;
        const double pressure =
            contact.peak_pa * contact::disc_average_exact(a, u, v, side / kParts) / (a * kParts * kParts);
        const double give_x = contact.shift_x - contact.turn * v / a,
                     give_y = contact.shift_y + contact.turn * u / a;
        const double give = std::hypot(give_x, give_y), share = pressure / contact.peak_pa * kParts * kParts;
        const double carried = give > 0 ? std::min(1.0, share / give) : 0;  // of what the spring would hold
        const double scale = contact.friction * contact.peak_pa * carried / (kParts * kParts);
        const double inside = pressure > 0 ? 1 : 0;
        p += pressure;
        qx += inside * scale * give_x;
        qy += inside * scale * give_y;
      }
      const double area = layout_.area_m2();
      normal_n_ += p * area;
      shear_x_n_ += qx * area;
      shear_y_n_ += qy * area;
      torque_nm_ += area * ((layout_.x_m()[i] - contact.center_x_m) * qy -
                            (layout_.y_m()[i] - contact.center_y_m) * qx);
      normal_[i] = static_cast<float>(p);
      x_[i] = static_cast<float>(qx);
      y_[i] = static_cast<float>(qy);
    }
    std::uniform_real_distribution<float> unit(-1, 1);
    const auto width = static_cast<float>(contact.noise * contact.peak_pa);
    for (auto* channel : {&normal_, &x_, &y_}) {
      for (float& value : *channel) value += width * unit(random_);
    }
    ++sequence_;
    return {sequence_, static_cast<std::int64_t>(sequence_) * 1'000'000, normal_, x_, y_};
  }

  const TaxelLayout& layout() const { return layout_; }
  // Of the last frame, without its noise.
  double normal_n() const { return normal_n_; }
  double shear_x_n() const { return shear_x_n_; }
  double shear_y_n() const { return shear_y_n_; }
  double torque_nm() const { return torque_nm_; }

 private:
  TaxelLayout layout_;
  std::mt19937_64 random_;
  std::vector<float> normal_, x_, y_;
  double normal_n_ = 0, shear_x_n_ = 0, shear_y_n_ = 0, torque_nm_ = 0;
  std::uint64_t sequence_ = 0;
};

}  // namespace slipd::synthetic
