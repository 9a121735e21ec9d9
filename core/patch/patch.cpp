#include "core/patch/patch.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

// A taxel that stands out of the noise by this many standard deviations is touched: Gaussian noise does so
// once in a few million taxels, uniform noise never (its bound is 1.73).
constexpr double kStandsOut = 5;

// The disc is taken this much wider than the contact, so that a radius found a little small loses nothing.
constexpr double kReach = 1.06;

constexpr int kRefinements = 3;

}  // namespace

PatchFinder::PatchFinder(const TaxelLayout& layout)
    : layout_(layout),
      x_m_(layout.x_m().begin(), layout.x_m().end()),
      y_m_(layout.y_m().begin(), layout.y_m().end()) {
  const double half = layout.side_m() / 2;
  const auto [left, right] = std::minmax_element(layout.x_m().begin(), layout.x_m().end());
  const auto [bottom, top] = std::minmax_element(layout.y_m().begin(), layout.y_m().end());
  left_m_ = *left - half;
  right_m_ = *right + half;
  bottom_m_ = *bottom - half;
  top_m_ = *top + half;
  inside_.reserve(layout.size());
}

const ContactPatch& PatchFinder::find(const Frame& frame) noexcept {
  patch_ = {};
  inside_.clear();
  measure_normal_noise(frame);
  if (layout_.size() == 1) {  // one force vector: no place, no noise to measure
    patch_.touched = frame.normal_pa[0] > 0;
    inside_.push_back(0);
  } else if ((patch_.touched = locate(frame))) {
    refine(frame);
  }
  if (patch_.touched) {
    patch_.inside = inside_;
    sum_shear(frame);
    measure_shear_noise(frame);
    patch_.shear_sigma_n =
        patch_.noise_shear_pa * layout_.area_m2() * std::sqrt(static_cast<double>(inside_.size()));
  }
  return patch_;
}

// Pressure below zero is noise alone, and noise is as often above zero: the mean square of the negative
// readings is the variance of all, wherever the contact may lie.
void PatchFinder::measure_normal_noise(const Frame& frame) noexcept {
  float sum = 0, peak = 0;
  std::uint32_t count = 0;
  const float* pressure = frame.normal_pa.data();
#pragma omp simd reduction(+ : sum, count) reduction(max : peak)
  for (std::size_t i = 0; i < x_m_.size(); ++i) {
    const float p = pressure[i], negative = p < 0 ? p : 0;
    sum += negative * negative;
    count += p < 0 ? 1U : 0U;
    peak = peak > p ? peak : p;
  }
  peak_pa_ = peak;
  if (count > 0) patch_.noise_normal_pa = std::sqrt(static_cast<double>(sum) / count);
}

// Centroid and radius of what stands out.
bool PatchFinder::locate(const Frame& frame) noexcept {
  if (!(peak_pa_ > kStandsOut * patch_.noise_normal_pa) || peak_pa_ <= 0) return false;
  const float least = static_cast<float>(std::max(4 * patch_.noise_normal_pa, 0.02 * peak_pa_));
  double p = 0, px = 0, py = 0, pr = 0;
  const float *pressure = frame.normal_pa.data(), *x_m = x_m_.data(), *y_m = y_m_.data();
#pragma omp simd reduction(+ : p, px, py, pr)
  for (std::size_t i = 0; i < x_m_.size(); ++i) {
    const double value = pressure[i] < least ? 0 : pressure[i], x = x_m[i], y = y_m[i];
    p += value;
    px += value * x;
    py += value * y;
    pr += value * (x * x + y * y);
  }
  patch_.center_x_m = px / p;
  patch_.center_y_m = py / p;
  const double spread =
      pr / p - patch_.center_x_m * patch_.center_x_m - patch_.center_y_m * patch_.center_y_m;
  const double side = layout_.side_m();
  patch_.radius_m = std::sqrt(2.5 * std::max(spread - side * side / 6, 0.05 * side * side));
  return true;
}

// The same from all taxels of the disc found so far, those that noise left below the threshold included.
void PatchFinder::refine(const Frame& frame) noexcept {
  const double side = layout_.side_m();
  for (int round = 0; round < kRefinements; ++round) {
    gather(kReach * patch_.radius_m + 0.7072 * side);
    double p = 0, px = 0, py = 0, pr = 0;
    for (const std::uint32_t i : inside_) {
      const double value = frame.normal_pa[i];
      const double x = x_m_[i] - patch_.center_x_m, y = y_m_[i] - patch_.center_y_m;
      p += value;
      px += value * x;
      py += value * y;
      pr += value * (x * x + y * y);
    }
    if (!(p > 0)) {
      patch_.touched = false;
      return;
    }
    const double dx = px / p, dy = py / p;
    const double spread = pr / p - dx * dx - dy * dy - side * side / 6;
    patch_.center_x_m += dx;
    patch_.center_y_m += dy;
    patch_.radius_m = std::sqrt(2.5 * std::max(spread, 0.05 * side * side));
    patch_.normal_n = p * layout_.area_m2();
  }
  // One taxel may stand out by chance; a contact does so as a whole.
  const double chance = patch_.noise_normal_pa * std::sqrt(static_cast<double>(inside_.size()));
  if (patch_.normal_n < kStandsOut * chance * layout_.area_m2()) {
    patch_.touched = false;
    return;
  }
  const double a = patch_.radius_m - 0.25 * side;
  patch_.cut = patch_.center_x_m - a < left_m_ || patch_.center_x_m + a > right_m_ ||
               patch_.center_y_m - a < bottom_m_ || patch_.center_y_m + a > top_m_;
}

void PatchFinder::gather(double reach_m) noexcept {
  inside_.clear();
  const auto reach2 = static_cast<float>(reach_m * reach_m);
  const auto cx = static_cast<float>(patch_.center_x_m), cy = static_cast<float>(patch_.center_y_m);
  const auto take = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const float x = x_m_[i] - cx, y = y_m_[i] - cy;
      if (x * x + y * y < reach2) inside_.push_back(static_cast<std::uint32_t>(i));
    }
  };
  const auto& grid = layout_.regular();
  if (!grid) {
    take(0, x_m_.size());
    return;
  }
  // Of a grid only the rows and columns that the disc may reach.
  const auto index = [](double place, double pitch, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(place / pitch, 0.0, static_cast<double>(count)));
  };
  const std::size_t first_row = index(patch_.center_y_m - reach_m - bottom_m_, grid->pitch_m, grid->rows);
  const std::size_t end_row =
      index(patch_.center_y_m + reach_m - bottom_m_ + grid->pitch_m, grid->pitch_m, grid->rows);
  const std::size_t first = index(patch_.center_x_m - reach_m - left_m_, grid->pitch_m, grid->columns);
  const std::size_t end =
      index(patch_.center_x_m + reach_m - left_m_ + grid->pitch_m, grid->pitch_m, grid->columns);
  for (std::size_t row = first_row; row < end_row; ++row)
    take(row * grid->columns + first, row * grid->columns + end);
}

void PatchFinder::sum_shear(const Frame& frame) noexcept {
  double x = 0, y = 0, p = 0;
  for (const std::uint32_t i : inside_) {
    x += frame.shear_x_pa[i];
    y += frame.shear_y_pa[i];
    p += frame.normal_pa[i];
  }
  const double area = layout_.area_m2();
  patch_.normal_n = p * area;
  patch_.shear_x_n = x * area;
  patch_.shear_y_n = y * area;
  patch_.shear_n = std::hypot(patch_.shear_x_n, patch_.shear_y_n);
  if (patch_.shear_n > 0) {
    patch_.toward_x = patch_.shear_x_n / patch_.shear_n;
    patch_.toward_y = patch_.shear_y_n / patch_.shear_n;
  }
}

// Off the contact there is no shear: what is read there along the resultant is noise.
void PatchFinder::measure_shear_noise(const Frame& frame) noexcept {
  const std::size_t off = x_m_.size() - inside_.size();
  if (off < 8) {  // hardly a taxel is free: taken as noisy as the pressure
    patch_.noise_shear_pa = patch_.noise_normal_pa;
    return;
  }
  const auto tx = static_cast<float>(patch_.toward_x), ty = static_cast<float>(patch_.toward_y);
  double all = 0, in = 0;
  const float *shear_x = frame.shear_x_pa.data(), *shear_y = frame.shear_y_pa.data();
#pragma omp simd reduction(+ : all)
  for (std::size_t i = 0; i < x_m_.size(); ++i) {
    const float along = tx * shear_x[i] + ty * shear_y[i];
    all += along * along;
  }
  for (const std::uint32_t i : inside_) {
    const auto along = static_cast<float>(patch_.shear_along_pa(frame, i));
    in += along * along;
  }
  patch_.noise_shear_pa = std::sqrt(std::max(0.0, all - in) / static_cast<double>(off));
}

}  // namespace slipd
