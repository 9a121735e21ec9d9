#include "core/reading/fit/normal_equations/contact_shape.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/numeric/norm.hpp"
#include "core/reading/fit/normal_equations/field_slopes.hpp"

namespace slipd {
namespace {

// An ellipse's axes are apart by at least this, log of their ratio: else its angle means nothing.
constexpr double kLeastLogAxes = 1e-3;

// Even numbers in 0 … 1 for successive taxels of a row, and of rows.
double even_number(std::uint32_t taxel) noexcept {
  constexpr double kGolden = 0.6180339887498949;
  const double turns = kGolden * (taxel + 1);
  return turns - std::floor(turns);
}

}  // namespace

ContactShape::ContactShape(const TaxelLayout& layout, double depth_m, std::optional<double> bonded_poisson)
    : layout_(layout),
      depth_m_(depth_m),
      outer_(layout.size(), layout.side_m(), depth_m, bonded_poisson),
      inner_(layout.size(), layout.side_m(), depth_m, bonded_poisson),
      round_(layout.side_m(), depth_m, bonded_poisson),
      axes_(depth_m, bonded_poisson),
      taxel_(layout.size()) {
  for (auto* list : {&x_, &y_, &u_, &v_}) list->resize(layout.size());
  for (auto* list : {&all_data_, &data_, &residuals_}) list->resize(3 * layout.size());
  choose_field_loops();
}

std::size_t ContactShape::memory_bytes() const noexcept {
  // Places and numbers; data twice and residuals of three channels.
  constexpr std::size_t kPlaces = 5, kOfChannels = 9;
  return layout_.size() * sizeof(double) * (kPlaces + kOfChannels) + outer_.memory_bytes() +
         inner_.memory_bytes() + round_.memory_bytes() + axes_.memory_bytes();
}

void ContactShape::Sums::add(double weight, const Sums& other) noexcept {
  cost += weight * other.cost;
  gradient += weight * other.gradient;
  hessian += weight * other.hessian;
}

void ContactShape::Normal::change_noise(const Noise& before, const Noise& after) noexcept {
  const auto weigh = [](Sums& sums, double ratio) {
    sums.cost *= ratio * ratio;
    sums.gradient *= ratio * ratio;
    sums.hessian *= ratio * ratio;
  };
  weigh(of_pressure, before.normal_pa / after.normal_pa);
  weigh(of_shear, before.shear_pa / after.shear_pa);
  static_cast<Sums&>(*this) = of_pressure;
  add(1, of_shear);
}

void ContactShape::set_depth(double log) noexcept {
  if (!(depth_m_ > 0) || log == depth_log_) return;
  depth_log_ = log;
  const double depth_m = depth_m_ * std::exp(log);
  outer_.set_depth(depth_m);
  inner_.set_depth(depth_m);
  round_.set_depth(depth_m);
  axes_.set_depth(depth_m);
}

void ContactShape::collect(const ContactPatch& patch, const contact::Ellipse& reach,
                           std::size_t all_below) noexcept {
  frame_ = {};
  const bool all = layout_.size() <= all_below;
  const double along_x = std::cos(reach.angle_rad) / reach.a_m,
               along_y = std::sin(reach.angle_rad) / reach.a_m,
               across_x = -std::sin(reach.angle_rad) / reach.b_m,
               across_y = std::cos(reach.angle_rad) / reach.b_m;
  for (std::uint32_t i = 0; i < layout_.size(); ++i) {
    const double x = layout_.x_m()[i] - patch.center_x_m, y = layout_.y_m()[i] - patch.center_y_m;
    const double u = along_x * x + along_y * y, v = across_x * x + across_y * y;
    if (all || u * u + v * v < 1) taxel_[frame_.collected++] = i;
  }
  for (std::size_t j = 0; j < frame_.collected; ++j) {
    const std::uint32_t i = taxel_[j];
    all_data_[j] = patch.taxels.normal_pa[i];
    all_data_[frame_.collected + j] = patch.taxels.shear_x_pa[i];
    all_data_[2 * frame_.collected + j] = patch.taxels.shear_y_pa[i];
  }
  use_all();
}

void ContactShape::collect_nothing() noexcept {
  frame_.collected = layout_.size();
  std::iota(taxel_.begin(), taxel_.end(), 0U);
  std::fill(all_data_.begin(), all_data_.end(), 0.0);
  use_all();
}

void ContactShape::use_part(std::size_t taxels) noexcept {
  const double share = std::min(
      1.0, static_cast<double>(taxels) / static_cast<double>(std::max<std::size_t>(frame_.collected, 1)));
  frame_.count = 0;
  for (std::size_t j = 0; j < frame_.collected; ++j) {
    if (share < 1 && even_number(taxel_[j]) >= share) continue;
    u_[frame_.count] = static_cast<double>(j);
    ++frame_.count;
  }
  choose(frame_.count, Detail::rough);
}

void ContactShape::use_all() noexcept {
  for (std::size_t j = 0; j < frame_.collected; ++j) u_[j] = static_cast<double>(j);
  choose(frame_.collected, Detail::exact);
}

// u_ has the places of those in use among the collected.
void ContactShape::choose(std::size_t count, Detail detail) noexcept {
  frame_.count = count;
  frame_.detail = detail;
  for (std::size_t i = 0; i < frame_.count; ++i) {
    const auto j = static_cast<std::size_t>(u_[i]);
    x_[i] = layout_.x_m()[taxel_[j]];
    y_[i] = layout_.y_m()[taxel_[j]];
    for (std::size_t channel = 0; channel < 3; ++channel)
      data_[channel * frame_.count + i] = all_data_[channel * frame_.collected + j];
  }
}

contact::Ellipse ContactShape::ellipse_of(const Full& at, double scale) noexcept {
  const double apart = norm(at[along], at[across]), stretch = std::exp(0.5 * apart);
  return {scale * at[size] * stretch, scale * at[size] / stretch, 0.5 * std::atan2(at[across], at[along])};
}

void ContactShape::change_noise(const Noise& noise) noexcept {
  const double normal = frame_.noise.normal_pa / noise.normal_pa,
               shear = frame_.noise.shear_pa / noise.shear_pa;
  for (std::size_t i = 0; i < frame_.count; ++i) residuals_[i] *= normal;
  for (std::size_t i = frame_.count; i < 3 * frame_.count; ++i) residuals_[i] *= shear;
  frame_.noise = noise;
}

void ContactShape::place(const Full& at) noexcept {
  set_depth(at[depth]);
  for (std::size_t i = 0; i < frame_.count; ++i) {
    u_[i] = x_[i] - at[center_x];
    v_[i] = y_[i] - at[center_y];
  }
}

const contact::SubsurfaceSheet& ContactShape::show(const Full& at, Detail detail) noexcept {
  place(at);
  outer_.evaluate_values(ellipse_of(at, 1), u(), v(), detail);
  return outer_;
}

const contact::SubsurfaceSheet& ContactShape::show_slopes(const Full& at) noexcept {
  place(at);
  outer_.evaluate(ellipse_of(at, 1), u(), v(), Detail::rough);
  return outer_;
}

const contact::SubsurfaceSheet& ContactShape::show_part(const Full& at, double scale,
                                                        Detail detail) noexcept {
  inner_.evaluate_values(ellipse_of(at, scale), u(), v(), detail);
  return inner_;
}

void ContactShape::spread(const ChannelProducts& products, int unknowns, Normal& normal) noexcept {
  const auto fill = [unknowns](const ChannelProducts::Products& from, Sums& to) {
    const double* next = from.data();
    to.gradient.resize(unknowns);
    to.hessian.resize(unknowns, unknowns);
    for (int row = 0; row < unknowns; ++row) {
      for (int col = 0; col <= row; ++col) to.hessian(row, col) = to.hessian(col, row) = *next++;
    }
    for (int row = 0; row < unknowns; ++row) to.gradient[row] = *next++;
    to.cost = 0.5 * *next;
  };
  fill(products.pressure, normal.of_pressure);
  fill(products.shear, normal.of_shear);
  static_cast<Sums&>(normal) = normal.of_pressure;
  normal.add(1, normal.of_shear);
}

double ContactShape::farthest_m(const Full& at) const noexcept {
  double most_m2 = 0;
  for (std::size_t i = 0; i < frame_.count; ++i) {
    const double x = x_[i] - at[center_x], y = y_[i] - at[center_y];
    most_m2 = std::max(most_m2, x * x + y * y);
  }
  return std::sqrt(most_m2) + layout_.side_m();
}

RoundTrial ContactShape::trial_of(const Full& at) noexcept {
  return {.x_m = at[center_x],
          .y_m = at[center_y],
          .radius_m = at[size],
          .peak_pa = at[peak],
          .load = at[load],
          .gamma = at[margin],
          .direction_rad = at[direction]};
}

RoundTask ContactShape::task() noexcept {
  return {.x_m = x_.data(),
          .y_m = y_.data(),
          .data_pa = data_.data(),
          .residuals = residuals_.data(),
          .count = frame_.count,
          .per_normal = 1 / frame_.noise.normal_pa,
          .per_shear = 1 / frame_.noise.shear_pa};
}

bool ContactShape::evaluate_round(const Full& at, Normal& normal) noexcept {
  if (!(depth_m_ > 0)) return false;
  const double reach_m = farthest_m(at);
  if (!round_.pays(frame_.count, reach_m, frame_.detail, outer_.points(frame_.detail))) return false;
  ChannelProducts products;
  round_.linearise(trial_of(at), reach_m, frame_.detail, task(), products);
  spread(products, kRound, normal);
  return true;
}

void ContactShape::evaluate_sheets(const Full& from, int unknowns, Detail detail, bool residuals_given,
                                   Normal& normal) noexcept {
  Full at = from;
  if (unknowns == kRound) {
    at[along] = at[across] = 0;
  } else if (norm(at[along], at[across]) < kLeastLogAxes) {
    at[along] = kLeastLogAxes;
    at[across] = 0;
  }
  place(at);
  const double k = std::cbrt(at[margin]), rest = 1 - at[margin], apart = norm(at[along], at[across]);
  const contact::Ellipse wide = ellipse_of(at, 1), narrow = ellipse_of(at, k);
  outer_.evaluate(wide, u(), v(), detail);
  inner_.evaluate(narrow, u(), v(), detail);
  const double per_apart = apart > 0 ? 1 / apart : 0;
  const FieldSlopes by{.outer = FieldRows(outer_),
                       .inner = FieldRows(inner_),
                       .wide = wide,
                       .narrow = narrow,
                       .peak = at[peak],
                       .shear = at[peak] * at[load] / rest,
                       .k = k,
                       .rest = rest,
                       .dk = 1 / (3 * k * k),
                       .c = std::cos(at[direction]),
                       .s = std::sin(at[direction]),
                       .c2 = at[along] * per_apart,
                       .s2 = at[across] * per_apart,
                       .turn = 0.5 * per_apart,
                       .per_size = 1 / at[size],
                       .per_normal = 1 / frame_.noise.normal_pa,
                       .per_shear = 1 / frame_.noise.shear_pa,
                       .surface = !(depth_m_ > 0),
                       .residuals_given = residuals_given,
                       .symmetric = outer_.symmetric(),
                       .data = data_.data(),
                       .residuals = residuals_.data(),
                       .count = frame_.count};
  ChannelProducts products;
  linearise_field(by, unknowns, products);
  spread(products, unknowns, normal);
}

void ContactShape::evaluate(const Full& at, int unknowns, Normal& normal) noexcept {
  set_depth(at[depth]);
  if (unknowns != kRound || !evaluate_round(at, normal))
    evaluate_sheets(at, unknowns, frame_.detail, false, normal);
}

// With all other unknowns free.
double ContactShape::axes_sigmas2(const Square& hessian, const Eigen::Vector2d& axes) noexcept {
  const Square covariance = hessian.ldlt().solve(Square::Identity(kMost, kMost));
  const Eigen::Matrix2d spread = covariance.bottomRightCorner<2, 2>();
  return axes.dot(spread.ldlt().solve(axes));
}

double ContactShape::axes_sigmas2(const Full& at) noexcept {
  if (depth_m_ > 0) {
    const double reach_m = farthest_m(at);
    if (axes_.reaches(reach_m)) return axes_.sigmas2(trial_of(at), reach_m, task());
  }
  Normal normal;
  evaluate_sheets(at, kMost, Detail::rough, true, normal);
  normal.hessian(depth, depth) += kHeldDepth;
  const Vector step = -normal.hessian.ldlt().solve(normal.gradient);
  return axes_sigmas2(normal.hessian, step.tail<2>());
}

}  // namespace slipd
