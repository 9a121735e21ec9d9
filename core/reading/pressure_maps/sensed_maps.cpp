#include "core/reading/pressure_maps/sensed_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/frame/model_errors.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/pressure_maps/taxel_sums.hpp"

namespace slipd {
namespace {

// Wave numbers of which the skin leaves less are noise; share of the pressure, 0 … 0.3. Too small: maps keep
// their noise. Too large: small contacts lose their edge.
constexpr double kLeastSensed = 0.1;

}  // namespace

SensedMaps::SensedMaps(const TaxelLayout& layout, const Skin& skin, std::size_t trials)
    : taxels_(layout.size()),
      columns_(layout.regular().value().columns),
      rows_(layout.regular().value().rows),
      depth_(skin.depth_m, skin.depth_sigma),
      ratio_(layout.regular().value(), skin.depth_m, kLeastSensed),
      sensed_(RecordedMaps::kMaps * 2 * kChannels * taxels_),
      read_pa_(kChannels * taxels_),
      pressure_pa_(taxels_),
      ways_(kWays * taxels_),
      scratch_(6 * taxels_),
      trials_(trials) {}

std::size_t SensedMaps::memory_bytes() const noexcept {
  return ratio_.memory_bytes() + sizeof(Slipping) * trials_.size() +
         sizeof(float) *
             (sensed_.size() + read_pa_.size() + pressure_pa_.size() + ways_.size() + scratch_.size());
}

void SensedMaps::read(const TaxelView& taxels, const RecordedMaps& maps, double normal_n) noexcept {
  frame_ = {};
  smooth(maps);
  today_ = at(maps, normal_n);
  const std::span<float> x = std::span(read_pa_).first(taxels_),
                         y = std::span(read_pa_).subspan(taxels_, taxels_);
  std::copy_n(taxels.shear_x_pa, taxels_, x.begin());
  std::copy_n(taxels.shear_y_pa, taxels_, y.begin());
  add_maps(x, -1, maps, today_, RecordedMaps::shear_x);
  add_maps(y, -1, maps, today_, RecordedMaps::shear_y);
  std::fill(pressure_pa_.begin(), pressure_pa_.end(), 0.0F);
  add_maps(pressure_pa_, 1, maps, today_, RecordedMaps::normal);
  const auto count = static_cast<double>(taxels_);
  frame_.map_pa2 = taxel_dot(pressure_pa_, pressure_pa_) / count;
  find_ways();
  taxel_vector(std::span(pressure_pa_)) =
      taxel_vector(std::span(taxels.normal_pa, taxels_)) - taxel_vector(std::span(pressure_pa_));
  const double share = noise_share(today_);
  frame_.pressing_share = share / (1 + share);
  frame_.shear_pa2 = 0.5 * (noise_of(x) + noise_of(y));
  frame_.normal_pa2 = noise_of(pressure_pa_) / (1 + share);
  frame_.map_pa2 -= share * frame_.normal_pa2;
  weigh_pressure(maps, normal_n);
  multiply(maps);
  for (std::size_t i = 0; i < trials_.size(); ++i) {
    Slipping& trial = trials_[i];
    trial.weights =
        today_ - at(maps, (static_cast<double>(i) + 0.5) / static_cast<double>(trials_.size()) * normal_n);
    trial.noise_share = noise_share(trial.weights);
    const double by_noise = map_noise_pa2() * trial.noise_share;
    trial.xx = product(pulls_.xx, trial.weights, trial.weights) - by_noise;
    trial.xy = product(pulls_.xy, trial.weights, trial.weights);
    trial.yy = product(pulls_.yy, trial.weights, trial.weights) - by_noise;
  }
}

void SensedMaps::multiply(const RecordedMaps& maps) noexcept {
  const std::span<const float> all(read_pa_), shear = all.first(2 * taxels_), pressure = all.last(taxels_);
  for (Weights* of : {&of_x_, &of_y_, &shear_of_x_, &shear_of_y_}) of->setZero(roots_.size());
  for (std::size_t map = 0; map < maps.size(); ++map) {
    const auto i = static_cast<Eigen::Index>(map);
    const std::span<const float> by_x = sensed_of(maps.slot(map), false),
                                 by_y = sensed_of(maps.slot(map), true);
    shear_of_x_[i] = taxel_dot(shear, by_x.first(2 * taxels_));
    shear_of_y_[i] = taxel_dot(shear, by_y.first(2 * taxels_));
    of_x_[i] = shear_of_x_[i] + taxel_dot(pressure, by_x.last(taxels_));
    of_y_[i] = shear_of_y_[i] + taxel_dot(pressure, by_y.last(taxels_));
  }
}

// Least squares of the pull's two components.
SensedMaps::Pull SensedMaps::pull(std::size_t trial) const noexcept {
  const Slipping& of = trials_[trial];
  const double bx = of.weights.dot(of_x_), by = of.weights.dot(of_y_);
  const double determinant = of.xx * of.yy - of.xy * of.xy;
  Pull out;
  if (!(of.xx > 0 && of.yy > 0 && determinant > 0)) return out;
  out.x = (of.yy * bx - of.xy * by) / determinant;
  out.y = (of.xx * by - of.xy * bx) / determinant;
  const double friction2 = out.x * out.x + out.y * out.y;
  if (friction2 > 0)
    out.square_pa2 = (out.x * out.x * of.xx + 2 * out.x * out.y * of.xy + out.y * out.y * of.yy) / friction2;
  out.residual_pa2 = std::max(0.0, frame_.square_pa2 - (out.x * bx + out.y * by));
  const double maps_part = friction2 * map_noise_pa2() / frame_.values * of.noise_share;
  out.noise_pa2 = std::max(frame_.shear_pa2 + maps_part, std::numeric_limits<double>::min());
  out.map_share = maps_part / out.noise_pa2;
  return out;
}

// Along the pull.
double SensedMaps::history_gain(std::size_t trial, const Pull& pull) const noexcept {
  const double friction = norm(pull.x, pull.y);
  if (!(friction > 0)) return 0;
  const double c = pull.x / friction, s = pull.y / friction;
  const Square along = of_pulls(pulls_, c, s);
  const Weights read = c * of_x_ + s * of_y_;
  const auto square = [&](const Slipping& of) { return c * c * of.xx + 2 * c * s * of.xy + s * s * of.yy; };
  const Slipping& found = trials_[trial];
  const Weights with_found = along.lazyProduct(found.weights),
                noise_with_found = per_frames_.cwiseProduct(found.weights);
  const double noise_pa2 = map_noise_pa2();
  const double by_maps = kUnevenShare * friction,
               variance_pa2 = pull.noise_pa2 + by_maps * by_maps * pull.square_pa2;
  const double found_pa2 = square(found), left = read.dot(found.weights) / found_pa2;
  double gain = 0;
  for (const Slipping& other : trials_) {
    const double other_pa2 = square(other);
    const double common_pa2 = other.weights.dot(with_found) - noise_pa2 * other.weights.dot(noise_with_found);
    const double own_pa2 = other_pa2 - common_pa2 * common_pa2 / found_pa2;
    // Of a difference that is nearly the same, or noise, nothing is left.
    if (!(found_pa2 > 0 && own_pa2 > kUnlike * other_pa2 && own_pa2 > noise_pa2 * other.noise_share))
      continue;
    const double product_pa2 = read.dot(other.weights) - common_pa2 * left;
    gain = std::max(gain, product_pa2 * product_pa2 / (own_pa2 * variance_pa2));
  }
  return gain;
}

// The pressure is left out: its noise would draw five terms towards 0.
bool SensedMaps::superpose(const RecordedMaps& maps, double normal_n, double direction_x, double direction_y,
                           JaegerDecomposition& out) noexcept {
  const Square along = of_pulls(sensed_as_shear_, direction_x, direction_y);
  const Weights read = direction_x * shear_of_x_ + direction_y * shear_of_y_;
  std::array<Weights, JaegerDecomposition::kTerms> terms;
  JaegerDecomposition::Read sums{.products = {},
                                 .noise_shares = {},
                                 .sensed = {},
                                 .shear_pa2 = frame_.shear_square_pa2,
                                 .values = static_cast<double>(2 * taxels_),
                                 .noise_pa2 = std::max(frame_.shear_pa2, std::numeric_limits<double>::min()),
                                 .map_noise_pa2 = 0.5 * frame_.normal_pa2 * ratio_.noise_gain()};
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i] = at(maps, JaegerDecomposition::share_of(i) * normal_n);
    const auto row = static_cast<Eigen::Index>(i);
    sums.sensed[row] = terms[i].dot(read);
    for (std::size_t map = 0; map < maps.size(); ++map)
      out.add(i, maps.force_n(map), terms[i][static_cast<Eigen::Index>(map)]);
    for (std::size_t j = 0; j <= i; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      const double share = terms[i].cwiseProduct(per_frames_).dot(terms[j]);
      sums.noise_shares(row, column) = sums.noise_shares(column, row) = share;
      sums.products(row, column) = sums.products(column, row) = product(along, terms[i], terms[j]);
    }
  }
  if (!out.solve(sums)) return false;
  superposed_.setZero(roots_.size());
  for (std::size_t i = 0; i < terms.size(); ++i)
    superposed_ += out.friction()[static_cast<Eigen::Index>(i)] * terms[i];
  return true;
}

double SensedMaps::unlike(const RecordedMaps& maps, std::size_t trial, const Pull& pull) noexcept {
  return unlike(maps, trials_[trial].weights, pull.x, pull.y);
}

double SensedMaps::unlike_superposed(const RecordedMaps& maps, double direction_x,
                                     double direction_y) noexcept {
  return unlike(maps, superposed_, direction_x, direction_y);
}

double SensedMaps::unlike(const RecordedMaps& maps, const Weights& slipping, double friction_x,
                          double friction_y) noexcept {
  add_maps(pressure_pa_, -friction_x, maps, slipping, RecordedMaps::shear_x);
  add_maps(pressure_pa_, -friction_y, maps, slipping, RecordedMaps::shear_y);
  const double noise_pa2 =
      frame_.normal_pa2 * (1 + noise_share(today_)) +
      (friction_x * friction_x + friction_y * friction_y) * frame_.shear_pa2 * noise_share(slipping);
  const double off_pa2 = taxel_dot(pressure_pa_, pressure_pa_) / static_cast<double>(taxels_);
  return frame_.map_pa2 > 0 ? (off_pa2 - noise_pa2) / frame_.map_pa2
                            : std::numeric_limits<double>::infinity();
}

TaxelView SensedMaps::without_pull(const RecordedMaps& maps) noexcept {
  pulled_ = true;
  add_maps(pressure_pa_, 1, maps, today_, RecordedMaps::normal);
  const std::span<float> sensed = std::span(scratch_).first(2 * taxels_);
  ratio_.press(pressure_pa_, sensed.first(taxels_), sensed.last(taxels_));
  return {pressure_pa_.data(), sensed.data(), sensed.data() + taxels_};
}

void SensedMaps::deepen(const RecordedMaps& maps, std::size_t trial, const Pull& pull) noexcept {
  const Weights& slipping = trials_[trial].weights;
  const auto part = [this](std::size_t i) { return std::span(scratch_).subspan(i * taxels_, taxels_); };
  const std::span<float> map = part(0), xx = part(1), xy = part(2), yy = part(3), nx = part(4), ny = part(5);
  std::fill(map.begin(), map.end(), 0.0F);
  add_maps(map, 1, maps, slipping, RecordedMaps::normal);
  const auto qx = static_cast<float>(pull.x), qy = static_cast<float>(pull.y);
  const std::span<float> x = std::span(read_pa_).first(taxels_),
                         y = std::span(read_pa_).subspan(taxels_, taxels_),
                         normal = std::span(read_pa_).last(taxels_);
  const auto add_sensed = [&](float sign) {
    ratio_.apply(map, {xx, xy, yy, nx, ny});
    taxel_vector(x) += sign * (qx * taxel_vector(xx) + qy * taxel_vector(xy));
    taxel_vector(y) += sign * (qx * taxel_vector(xy) + qy * taxel_vector(yy));
    taxel_vector(nx) = qx * taxel_vector(nx) + qy * taxel_vector(ny);
    without_ways(nx);
    taxel_vector(normal) += sign * static_cast<float>(frame_.pressure_weight) * taxel_vector(nx);
  };
  // Towards the nominal depth where the other way is out of reach; the change is the same, with its sign.
  const double step = filtered_log_ > 0 ? -kDeeper : kDeeper;
  ratio_.set_depth(filtered_log_ + step);
  add_sensed(-1);
  ratio_.set_depth(filtered_log_);
  add_sensed(1);
  multiply(maps);
}

}  // namespace slipd
