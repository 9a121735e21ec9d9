#include "core/estimate/closing_skin.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

using Vector = Eigen::Map<Eigen::VectorXf>;
using ConstVector = Eigen::Map<const Eigen::VectorXf>;

Vector vector(std::span<float> values) noexcept {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

ConstVector vector(std::span<const float> values) noexcept {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

double dot(std::span<const float> a, std::span<const float> b) noexcept {
  return vector(a).dot(vector(b));
}

// values += factor times a sum of maps.
void add(std::span<float> values, double factor, const ClosingMaps& maps,
         const Eigen::Ref<const Eigen::VectorXd>& weights, ClosingMaps::Channel channel) noexcept {
  for (std::size_t map = 0; map < maps.size(); ++map)
    vector(values) += static_cast<float>(factor * weights[static_cast<Eigen::Index>(map)]) *
                      vector(maps.values(map, channel));
}

// Maps of two forces are alike whose roots differ by less than this, over the root of the greatest one; 0.1 …
// 0.5. Too small: maps keep their noise. Too large: what a map has of its own is smoothed away. These three
// by `sliplab tradeoff --imprints`.
constexpr double kAlike = 0.3;
// Noise of a frame that the smoothing counts with, over its peak; 0.002 … 0.05. Too small: maps keep their
// noise. Too large: margins of a quiet sensor are not as good as they could be.
constexpr double kNoise = 0.01;

// Wave numbers of which the skin leaves less are noise; share of the pressure, 0 … 0.3. Too small: maps keep
// their noise. Too large: small contacts lose their edge.
constexpr double kLeastFelt = 0.05;

// Change of the log of the depth from which on maps are filtered anew; 0.005 … 0.05. Too small: costs time.
// Too large: margins are off by as much.
constexpr double kSameDepth = 0.02;
// Of the shear that pressing is felt as, the share of its sum of squares that no depth explains and that
// leaves the depth unknown; 0.05 … 0.5. Too small: real skins never show their depth. Too large: a skin of
// another kind is taken for one of another depth.
constexpr double kMostUnexplained = 0.2;

// The share of a difference of maps that the one found must leave, for it to show another history; 0.001 …
// 0.1. Too small: noise is taken for a history. Too large: none is seen.
constexpr double kOwn = 0.01;

double covariance_of(double a, double b) noexcept {
  const double apart = (a - b) / kAlike;
  return std::exp(-0.5 * apart * apart);
}

}  // namespace

ClosingSkin::ClosingSkin(const TaxelLayout& layout, const Skin& skin, std::size_t trials)
    : taxels_(layout.size()),
      columns_(layout.regular().value().columns),
      rows_(layout.regular().value().rows),
      depth_(skin.depth_m, skin.depth_sigma),
      ratio_(layout.regular().value(), skin.depth_m, kLeastFelt),
      felt_(ClosingMaps::kMaps * 4 * taxels_),
      shear_pa_(2 * taxels_),
      pressure_pa_(taxels_),
      scratch_(4 * taxels_),
      trials_(trials) {}

std::size_t ClosingSkin::memory_bytes() const noexcept {
  return sizeof(*this) + ratio_.memory_bytes() +
         sizeof(float) * (felt_.size() + shear_pa_.size() + pressure_pa_.size() + scratch_.size());
}

bool ClosingSkin::ready(const ClosingMaps& maps) const noexcept {
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (version_[maps.slot(map)] != maps.version(map)) return false;
  }
  return true;
}

void ClosingSkin::forget() noexcept {
  depth_.forget();
  last_filling_ = kNone;
}

void ClosingSkin::prepare(const ClosingMaps& maps, std::size_t taxels, std::size_t filling) noexcept {
  if (filling != last_filling_ && maps.size() > 0) {
    find_depth(maps);
    last_filling_ = filling;
  }
  std::size_t most = std::max<std::size_t>(1, taxels / taxels_);
  for (std::size_t map = 0; map < maps.size() && most > 0; ++map) {
    const std::size_t slot = maps.slot(map);
    if (slot == filling || version_[slot] == maps.version(map)) continue;
    filter(maps, map);
    --most;
  }
}

void ClosingSkin::filter(const ClosingMaps& maps, std::size_t map) noexcept {
  const std::size_t slot = maps.slot(map);
  const std::span<float> by_x = felt_of(slot, false), by_y = felt_of(slot, true);
  ratio_.apply(maps.values(map, ClosingMaps::normal),
               {by_x.first(taxels_), by_x.last(taxels_), by_y.last(taxels_)});
  std::copy_n(by_x.begin() + static_cast<std::ptrdiff_t>(taxels_), taxels_, by_y.begin());
  version_[slot] = maps.version(map);
  smoothed_ = 0;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const std::size_t other = maps.slot(i);
    const std::span<const float> other_x = felt_of(other, false), other_y = felt_of(other, true);
    xx_[slot][other] = xx_[other][slot] = dot(by_x, other_x);
    yy_[slot][other] = yy_[other][slot] = dot(by_y, other_y);
    xy_[slot][other] = dot(by_x, other_y);
    xy_[other][slot] = dot(other_x, by_y);
  }
}

// One step of Newton's method on the log of the depth, by the map of the greatest force.
void ClosingSkin::find_depth(const ClosingMaps& maps) noexcept {
  if (!depth_.open()) return;
  smooth(maps);
  const Weights last = at(last_n_);
  const std::span<float> all(scratch_), map = all.first(taxels_), felt = all.subspan(taxels_, 2 * taxels_);
  const std::span<float> left(shear_pa_), x = left.first(taxels_), y = left.last(taxels_);
  for (const std::span<float> values : {map, left}) std::fill(values.begin(), values.end(), 0.0F);
  add(map, 1, maps, last, ClosingMaps::normal);
  add(x, 1, maps, last, ClosingMaps::shear_x);
  add(y, 1, maps, last, ClosingMaps::shear_y);
  const double felt_pa2 = dot(left, left), noise_pa2 = 0.5 * (noise_of(x) + noise_of(y));
  ratio_.set_depth(filtered_log_);
  ratio_.press(map, felt.first(taxels_), felt.last(taxels_));
  vector(left) -= vector(felt);
  // By a step towards the nominal depth, so that it is within reach.
  const double step = filtered_log_ > 0 ? -kDeeper : kDeeper;
  ratio_.set_depth(filtered_log_ + step);
  vector(felt) *= -1;
  const std::span<float> other = std::span(pressure_pa_), rest = all.last(taxels_);
  ratio_.press(map, other, rest);
  vector(felt.first(taxels_)) += vector(other);
  vector(felt.last(taxels_)) += vector(rest);
  ratio_.set_depth(filtered_log_);
  const double squares = dot(felt, felt) / (step * step), product = dot(left, felt) / step;
  if (!(squares > 0 && felt_pa2 > 0)) return;
  const double off_pa2 =
      dot(left, left) - product * product / squares - 2 * static_cast<double>(taxels_) * noise_pa2;
  if (off_pa2 > kMostUnexplained * felt_pa2) return;
  const LogDepth shown{filtered_log_ + product / squares,
                       std::max(SkinDepth::kLeastSigma, std::sqrt(noise_pa2 / squares))};
  depth_.forget();  // what smaller forces have shown is in these maps, too
  depth_.take(depth_.with(shown));
  const double log = std::clamp(depth_.now().mean, -KernelRatio::kReach, KernelRatio::kReach);
  if (std::fabs(log - filtered_log_) < kSameDepth) return;
  filtered_log_ = log;
  ratio_.set_depth(log);
  version_.fill(0);
}

// Mixed second differences leave of what a skin has smoothed nearly nothing, and of noise all.
double ClosingSkin::noise_of(std::span<const float> values) const noexcept {
  if (columns_ < 3 || rows_ < 3) return 0;
  double squares = 0;
  for (std::size_t row = 1; row + 1 < rows_; ++row) {
    const float* const middle = values.data() + row * columns_;
    const float* const below = middle - columns_;
    const float* const above = middle + columns_;
    const auto across = [&](std::size_t i) { return below[i] - 2 * middle[i] + above[i]; };
    float sum = 0;
    for (std::size_t i = 1; i + 1 < columns_; ++i) {
      const float mixed = across(i - 1) - 2 * across(i) + across(i + 1);
      sum += mixed * mixed;
    }
    squares += static_cast<double>(sum);
  }
  constexpr double kOfWhiteNoise = 36;
  return squares / (kOfWhiteNoise * static_cast<double>((columns_ - 2) * (rows_ - 2)));
}

void ClosingSkin::smooth(const ClosingMaps& maps) noexcept {
  std::uint64_t newest = 0;
  for (std::size_t map = 0; map < maps.size(); ++map) newest = std::max(newest, maps.version(map));
  if (newest == smoothed_) return;
  smoothed_ = newest;
  const auto size = static_cast<Eigen::Index>(maps.size());
  last_n_ = maps.force_n(maps.size() - 1);
  roots_.setZero(size + 1);
  per_frames_.setZero(size + 1);
  for (auto* of : {&of_xx_, &of_xy_, &of_yy_}) of->setZero(size + 1, size + 1);
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto map = static_cast<std::size_t>(i);
    roots_[i] = std::sqrt(maps.force_n(map) / last_n_);
    per_frames_[i] = 1 / maps.frames(map);
    for (Eigen::Index j = 0; j < size; ++j) {
      const std::size_t one = maps.slot(map), other = maps.slot(static_cast<std::size_t>(j));
      of_xx_(i, j) = xx_[one][other];
      of_xy_(i, j) = 0.5 * (xy_[one][other] + xy_[other][one]);
      of_yy_(i, j) = yy_[one][other];
    }
  }
  Square covariance(size + 1, size + 1);
  for (Eigen::Index i = 0; i <= size; ++i) {
    for (Eigen::Index j = 0; j <= size; ++j) covariance(i, j) = covariance_of(roots_[i], roots_[j]);
    covariance(i, i) += kNoise * kNoise * (i < size ? per_frames_[i] : 1e-3);
  }
  inverse_.setIdentity(size + 1, size + 1);
  const Eigen::LLT<Eigen::Ref<Square>> solved(covariance);
  solved.solveInPlace(inverse_);
}

ClosingSkin::Weights ClosingSkin::at(double normal_n) const noexcept {
  const double root = std::sqrt(normal_n / last_n_);
  Weights alike(roots_.size());
  for (Eigen::Index i = 0; i < roots_.size(); ++i) alike[i] = covariance_of(root, roots_[i]);
  return inverse_.lazyProduct(alike);
}

void ClosingSkin::read(const TaxelView& taxels, const ClosingMaps& maps, double normal_n) noexcept {
  smooth(maps);
  today_ = at(normal_n);
  const std::span<float> x = std::span(shear_pa_).first(taxels_), y = std::span(shear_pa_).last(taxels_);
  std::copy_n(taxels.shear_x_pa, taxels_, x.begin());
  std::copy_n(taxels.shear_y_pa, taxels_, y.begin());
  add(x, -1, maps, today_, ClosingMaps::shear_x);
  add(y, -1, maps, today_, ClosingMaps::shear_y);
  std::fill(pressure_pa_.begin(), pressure_pa_.end(), 0.0F);
  add(pressure_pa_, -1, maps, today_, ClosingMaps::normal);
  const auto count = static_cast<double>(taxels_);
  map_pa2_ = dot(pressure_pa_, pressure_pa_) / count;
  vector(std::span(pressure_pa_)) += vector(std::span(taxels.normal_pa, taxels_));
  const double share = noise_share(today_);
  pressing_share_ = share / (1 + share);
  shear_pa2_ = 0.5 * (noise_of(x) + noise_of(y));
  normal_pa2_ = noise_of(pressure_pa_) / (1 + share);
  map_pa2_ -= share * normal_pa2_;
  multiply(maps);
  for (std::size_t i = 0; i < trials_.size(); ++i) {
    Slipping& trial = trials_[i];
    trial.weights =
        today_ - at((static_cast<double>(i) + 0.5) / static_cast<double>(trials_.size()) * normal_n);
    trial.noise_share = noise_share(trial.weights);
    const double by_noise = count * normal_pa2_ * ratio_.noise_gain() * trial.noise_share;
    trial.xx = product(of_xx_, trial.weights, trial.weights) - by_noise;
    trial.xy = product(of_xy_, trial.weights, trial.weights);
    trial.yy = product(of_yy_, trial.weights, trial.weights) - by_noise;
  }
}

void ClosingSkin::multiply(const ClosingMaps& maps) noexcept {
  square_pa2_ = dot(shear_pa_, shear_pa_);
  of_x_.setZero(roots_.size());
  of_y_.setZero(roots_.size());
  for (std::size_t map = 0; map < maps.size(); ++map) {
    const auto i = static_cast<Eigen::Index>(map);
    of_x_[i] = dot(shear_pa_, felt_of(maps.slot(map), false));
    of_y_[i] = dot(shear_pa_, felt_of(maps.slot(map), true));
  }
}

// Least squares of the pull's two components.
ClosingSkin::Pull ClosingSkin::pull(std::size_t trial) const noexcept {
  const Slipping& of = trials_[trial];
  const double bx = of.weights.dot(of_x_), by = of.weights.dot(of_y_);
  const double determinant = of.xx * of.yy - of.xy * of.xy;
  Pull out;
  if (!(of.xx > 0 && of.yy > 0 && determinant > 0)) return out;
  out.x = (of.yy * bx - of.xy * by) / determinant;
  out.y = (of.xx * by - of.xy * bx) / determinant;
  out.residual_pa2 = std::max(0.0, square_pa2_ - (out.x * bx + out.y * by));
  const double maps_part =
      0.5 * (out.x * out.x + out.y * out.y) * normal_pa2_ * ratio_.noise_gain() * of.noise_share;
  out.noise_pa2 = std::max(shear_pa2_ + maps_part, std::numeric_limits<double>::min());
  out.map_share = maps_part / out.noise_pa2;
  return out;
}

// Along the pull.
double ClosingSkin::history_gain(std::size_t trial, const Pull& pull) const noexcept {
  const double friction = std::hypot(pull.x, pull.y);
  if (!(friction > 0)) return 0;
  const double c = pull.x / friction, s = pull.y / friction;
  const Square along = of_pulls(c, s);
  const Weights read = c * of_x_ + s * of_y_;
  const auto square = [&](const Slipping& of) { return c * c * of.xx + 2 * c * s * of.xy + s * s * of.yy; };
  const Slipping& found = trials_[trial];
  const Weights with_found = along.lazyProduct(found.weights),
                noise_with_found = per_frames_.cwiseProduct(found.weights);
  const double noise_pa2 = static_cast<double>(taxels_) * normal_pa2_ * ratio_.noise_gain();
  const double found_pa2 = square(found), left = read.dot(found.weights) / found_pa2;
  double gain = 0;
  for (const Slipping& other : trials_) {
    const double other_pa2 = square(other);
    const double common_pa2 = other.weights.dot(with_found) - noise_pa2 * other.weights.dot(noise_with_found);
    const double own_pa2 = other_pa2 - common_pa2 * common_pa2 / found_pa2;
    // Of a difference that is nearly the same, or noise, nothing is left.
    if (!(found_pa2 > 0 && own_pa2 > kOwn * other_pa2 && own_pa2 > noise_pa2 * other.noise_share)) continue;
    const double product_pa2 = read.dot(other.weights) - common_pa2 * left;
    gain = std::max(gain, product_pa2 * product_pa2 / (own_pa2 * pull.noise_pa2));
  }
  return gain;
}

bool ClosingSkin::superpose(const ClosingMaps& maps, double normal_n, double direction_x, double direction_y,
                            ClosingSuperposition& out) noexcept {
  const Square along = of_pulls(direction_x, direction_y);
  const Weights read = direction_x * of_x_ + direction_y * of_y_;
  std::array<Weights, ClosingSuperposition::kTerms> terms;
  const auto values = static_cast<double>(2 * taxels_);
  ClosingSuperposition::Read sums{.products = {},
                                  .noise_shares = {},
                                  .felt = {},
                                  .shear_pa2 = square_pa2_,
                                  .values = values,
                                  .noise_pa2 = std::max(shear_pa2_, std::numeric_limits<double>::min()),
                                  .map_noise_pa2 = 0.5 * normal_pa2_ * ratio_.noise_gain()};
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i] = at(ClosingSuperposition::kShares[i] * normal_n);
    const auto row = static_cast<Eigen::Index>(i);
    sums.felt[row] = terms[i].dot(read);
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

double ClosingSkin::unlike(const ClosingMaps& maps, std::size_t trial, const Pull& pull) noexcept {
  return unlike(maps, trials_[trial].weights, pull.x, pull.y);
}

double ClosingSkin::unlike_superposed(const ClosingMaps& maps, double direction_x,
                                      double direction_y) noexcept {
  return unlike(maps, superposed_, direction_x, direction_y);
}

double ClosingSkin::unlike(const ClosingMaps& maps, const Weights& slipping, double friction_x,
                           double friction_y) noexcept {
  add(pressure_pa_, -friction_x, maps, slipping, ClosingMaps::shear_x);
  add(pressure_pa_, -friction_y, maps, slipping, ClosingMaps::shear_y);
  const double noise_pa2 =
      normal_pa2_ * (1 + noise_share(today_)) +
      (friction_x * friction_x + friction_y * friction_y) * shear_pa2_ * noise_share(slipping);
  const double off_pa2 = dot(pressure_pa_, pressure_pa_) / static_cast<double>(taxels_);
  return map_pa2_ > 0 ? (off_pa2 - noise_pa2) / map_pa2_ : std::numeric_limits<double>::infinity();
}

TaxelView ClosingSkin::without_pull(const ClosingMaps& maps) noexcept {
  add(pressure_pa_, 1, maps, today_, ClosingMaps::normal);
  const std::span<float> felt = std::span(scratch_).first(2 * taxels_);
  ratio_.press(pressure_pa_, felt.first(taxels_), felt.last(taxels_));
  return {pressure_pa_.data(), felt.data(), felt.data() + taxels_};
}

void ClosingSkin::deepen(const ClosingMaps& maps, std::size_t trial, const Pull& pull) noexcept {
  const Weights& slipping = trials_[trial].weights;
  const std::span<float> map = std::span(scratch_).first(taxels_),
                         rest = std::span(scratch_).subspan(taxels_);
  const std::span<float> xx = rest.first(taxels_), xy = rest.subspan(taxels_, taxels_),
                         yy = rest.last(taxels_);
  std::fill(map.begin(), map.end(), 0.0F);
  add(map, 1, maps, slipping, ClosingMaps::normal);
  const auto qx = static_cast<float>(pull.x), qy = static_cast<float>(pull.y);
  const std::span<float> x = std::span(shear_pa_).first(taxels_), y = std::span(shear_pa_).last(taxels_);
  // Towards the nominal depth where the other way is out of reach; the change is the same, with its sign.
  const double step = filtered_log_ > 0 ? -kDeeper : kDeeper;
  ratio_.set_depth(filtered_log_ + step);
  ratio_.apply(map, {xx, xy, yy});
  ratio_.set_depth(filtered_log_);
  vector(x) -= qx * vector(xx) + qy * vector(xy);
  vector(y) -= qx * vector(xy) + qy * vector(yy);
  ratio_.apply(map, {xx, xy, yy});
  vector(x) += qx * vector(xx) + qy * vector(xy);
  vector(y) += qx * vector(xy) + qy * vector(yy);
  multiply(maps);
}

}  // namespace slipd
