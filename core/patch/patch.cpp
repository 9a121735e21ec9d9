#include "core/patch/patch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/frame/few_taxels.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// 0 times a value that is no finite number is none either.
bool all_finite(const Frame& frame) noexcept {
  float sum = 0;
  for (const auto& channel : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa}) {
#pragma omp simd reduction(+ : sum)
    for (std::size_t i = 0; i < channel.size(); ++i) sum += 0 * channel[i];
  }
  return sum == 0;
}

}  // namespace

PatchFinder::PatchFinder(const TaxelLayout& layout, const PatchOptions& options)
    : layout_(layout),
      options_(options),
      kernels_(best_kernels<DiscKernels>()),
      x_m_(layout.x_m().begin(), layout.x_m().end()),
      y_m_(layout.y_m().begin(), layout.y_m().end()) {
  const double half = layout.side_m() / 2;
  const auto [left, right] = std::minmax_element(layout.x_m().begin(), layout.x_m().end());
  const auto [bottom, top] = std::minmax_element(layout.y_m().begin(), layout.y_m().end());
  left_m_ = *left - half;
  right_m_ = *right + half;
  bottom_m_ = *bottom - half;
  top_m_ = *top + half;
  runs_.reserve(layout.size() / 2 + 1);
  rest_.reserve(layout.size() / 2 + 2);
  const std::size_t room = std::max(layout.size(), TaxelView::kLanes);
  x_m_.resize(room);
  y_m_.resize(room);
  channels_.resize(3 * room);
  dead_.reserve(static_cast<std::size_t>(options.most_dead_share * static_cast<double>(layout.size())) + 1);
}

const ContactPatch& PatchFinder::find(const Frame& frame) noexcept {
  patch_ = {};
  runs_.clear();
  view(frame);
  measure_normal_noise();
  if (layout_.size() == 1) {  // one force vector: no place, no noise to measure
    patch_.in_contact = frame.normal_pa[0] > 0;
    runs_.push_back({0, 1});
    patch_.count = 1;
  } else if ((patch_.in_contact = locate())) {
    if (refine() > 0 && interpolate_dead_taxels()) refine();
  }
  if (patch_.in_contact) {
    patch_.runs = runs_;
    sum_forces();
    measure_shear_noise();
    const double per_noise = layout_.area_m2() * std::sqrt(static_cast<double>(patch_.count));
    patch_.normal_sigma_n = per_noise * patch_.noise_normal_pa;
    patch_.shear_sigma_n = per_noise * patch_.noise_shear_pa;
    if (noise_) add_shared_noise();
    if (layout_.size() > 1) measure_torque();
  } else {  // no comparison is true of a value that is no number: it would pass for no pressure
    patch_.finite = patch_.finite && all_finite(frame);
  }
  return patch_;
}

void PatchFinder::view(const Frame& frame) noexcept {
  TaxelView& taxels = patch_.taxels;
  taxels = {
      frame.normal_pa.data(), frame.shear_x_pa.data(), frame.shear_y_pa.data(), x_m_.data(), y_m_.data(),
      layout_.size()};
  if (layout_.size() < TaxelView::kLanes) copy_channels();
}

void PatchFinder::copy_channels() noexcept {
  TaxelView& taxels = patch_.taxels;
  float* copy = channels_.data();
  for (auto* channel : {&taxels.normal_pa, &taxels.shear_x_pa, &taxels.shear_y_pa}) {
    if (*channel != copy) std::copy_n(*channel, taxels.size, copy);
    *channel = copy;
    copy += channels_.size() / 3;
  }
}

// docs/methods.md §20.1. Pressure below zero is noise alone, and noise is as often above zero: the mean
// square of the negative readings is the variance of all, wherever the contact may lie.
void PatchFinder::measure_normal_noise() noexcept {
  const NoiseSums sums = kernels_.noise(patch_.taxels);
  peak_pa_ = sums.peak;
  patch_.frame_peak_pa = sums.peak;
  patch_.frame_least_pa = sums.least;
  if (noise_) {
    patch_.noise_normal_pa = noise_->normal_pa;
    return;
  }
  if (sums.below > 0) patch_.noise_normal_pa = std::sqrt(sums.squares / static_cast<double>(sums.below));
}

// Hertz: <r^2> = 2 a^2/5, and a square taxel adds its own side^2/6.
double PatchFinder::radius_of(double second_moment_m2) const noexcept {
  const double side = layout_.side_m();
  return std::sqrt(2.5 *
                   std::max(second_moment_m2 - side * side / 6, options_.min_second_moment * side * side));
}

// Centroid and radius of what stands out.
bool PatchFinder::locate() noexcept {
  if (!(peak_pa_ > kStandsOutSigmas * patch_.noise_normal_pa) || peak_pa_ <= 0) return false;
  const auto least = static_cast<float>(
      std::max(options_.first_guess_sigmas * patch_.noise_normal_pa, options_.first_guess_share * peak_pa_));
  const PlaceSums sums = kernels_.place(patch_.taxels, least);
  patch_.center_x_m = sums.px / sums.p;
  patch_.center_y_m = sums.py / sums.p;
  const double spread =
      sums.prr / sums.p - patch_.center_x_m * patch_.center_x_m - patch_.center_y_m * patch_.center_y_m;
  patch_.radius_m = radius_of(spread);
  return patch_.finite = std::isfinite(patch_.radius_m);
}

// The same from all taxels of the disc found so far, those that noise left below the threshold included.
std::size_t PatchFinder::refine() noexcept {
  const double side = layout_.side_m();
  std::size_t dead_taxels = 0;
  for (int round = 0; round < options_.max_rounds; ++round) {
    gather(options_.reach_factor * patch_.radius_m + kHalfDiagonal * side);
    const PlaceSums sums = kernels_.weigh(patch_.taxels, runs_, static_cast<float>(patch_.center_x_m),
                                          static_cast<float>(patch_.center_y_m), dead_taxel_test());
    if (!(sums.p > 0)) {
      patch_.in_contact = false;
      return 0;
    }
    dead_taxels = sums.dead_taxels;
    const double dx = sums.px / sums.p, dy = sums.py / sums.p;
    const double radius_m = radius_of(sums.prr / sums.p - dx * dx - dy * dy);
    if (!std::isfinite(radius_m)) {
      patch_.in_contact = patch_.finite = false;
      return 0;
    }
    const double moved_m = std::max(norm(dx, dy), std::fabs(radius_m - patch_.radius_m));
    patch_.center_x_m += dx;
    patch_.center_y_m += dy;
    patch_.radius_m = radius_m;
    patch_.normal_n = sums.p * layout_.area_m2();
    if (moved_m < options_.settled_sides * side) break;
  }
  // One taxel may stand out by chance; a contact does so as a whole.
  const double chance = patch_.noise_normal_pa * std::sqrt(static_cast<double>(patch_.count));
  if (patch_.normal_n < kStandsOutSigmas * chance * layout_.area_m2()) {
    patch_.in_contact = false;
    return 0;
  }
  const double a = patch_.radius_m - options_.cut_slack_sides * side;
  patch_.cut = patch_.center_x_m - a < left_m_ || patch_.center_x_m + a > right_m_ ||
               patch_.center_y_m - a < bottom_m_ || patch_.center_y_m + a > top_m_;
  return dead_taxels;
}

// What a taxel of a contact's inner part always senses more than; nothing where noise is too loud to tell, or
// the contact too small.
DeadTaxelTest PatchFinder::dead_taxel_test() const noexcept {
  const double a = patch_.radius_m;
  if (!options_.fill_dead_taxels || a < kResolvedSides * layout_.side_m()) return {};
  if (kClearSigmas * patch_.noise_normal_pa > options_.dead_below_share * peak_pa_) return {};
  return {static_cast<float>(options_.dead_below_share * peak_pa_),
          static_cast<float>(options_.dead_within_share * a * a)};
}

bool PatchFinder::interpolate_dead_taxels() noexcept {
  dead_.clear();
  patch_.runs = runs_;
  const DeadTaxelTest dead_taxel_test = this->dead_taxel_test();
  const float* const p = patch_.taxels.normal_pa;
  std::size_t dead_taxels = 0;
  patch_.for_each_inside([&](std::uint32_t i) {
    const float x = x_m_[i] - static_cast<float>(patch_.center_x_m),
                y = y_m_[i] - static_cast<float>(patch_.center_y_m);
    if (p[i] >= dead_taxel_test.below_pa || x * x + y * y >= dead_taxel_test.within_m2) return;
    ++dead_taxels;
    const DeadTaxel dead = in_place_of(i, dead_taxel_test.below_pa);
    if (dead.neighbours >= options_.dead_min_neighbours && dead_.size() < dead_.capacity())
      dead_.push_back(dead);
  });
  if (dead_.empty() ||
      static_cast<double>(dead_taxels) > options_.most_dead_share * static_cast<double>(patch_.count))
    return false;  // it is the contact that is hollow
  copy_channels();
  float* const copy = channels_.data();
  const std::size_t room = channels_.size() / 3;
  for (const DeadTaxel& dead : dead_) {
    const auto share = 1 / static_cast<float>(dead.neighbours);
    copy[dead.taxel] = share * dead.normal_pa;
    copy[room + dead.taxel] = share * dead.shear_x_pa;
    copy[2 * room + dead.taxel] = share * dead.shear_y_pa;
  }
  patch_.interpolated = dead_.size();
  return true;
}

// The sums of its nearest neighbours that sense something.
PatchFinder::DeadTaxel PatchFinder::in_place_of(std::uint32_t taxel, float least_pa) const noexcept {
  DeadTaxel sums{.taxel = taxel};
  const TaxelView& sensed = patch_.taxels;
  const auto add = [&](std::size_t i) {
    if (sensed.normal_pa[i] < least_pa) return;
    ++sums.neighbours;
    sums.normal_pa += sensed.normal_pa[i];
    sums.shear_x_pa += sensed.shear_x_pa[i];
    sums.shear_y_pa += sensed.shear_y_pa[i];
  };
  if (const auto& grid = layout_.regular()) {
    const std::size_t column = taxel % grid->columns, row = taxel / grid->columns;
    if (column > 0) add(taxel - 1);
    if (column + 1 < grid->columns) add(taxel + 1);
    if (row > 0) add(taxel - grid->columns);
    if (row + 1 < grid->rows) add(taxel + grid->columns);
  } else {
    // On a grid between those beside it and the diagonal ones.
    const double near = (1 + std::numbers::sqrt2) / 2 * layout_.side_m();
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      const float x = x_m_[i] - x_m_[taxel], y = y_m_[i] - y_m_[taxel];
      if (x * x + y * y < near * near) add(i);
    }
  }
  return sums;
}

void PatchFinder::gather(double reach_m) noexcept {
  runs_.clear();
  patch_.count = 0;
  const auto reach2 = static_cast<float>(reach_m * reach_m);
  const auto cx = static_cast<float>(patch_.center_x_m), cy = static_cast<float>(patch_.center_y_m);
  const auto within = [&](std::size_t i) {
    const float x = x_m_[i] - cx, y = y_m_[i] - cy;
    return x * x + y * y < reach2;
  };
  const auto take = [&](std::size_t first, std::size_t end) {
    if (first == end) return;
    runs_.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end)});
    patch_.count += end - first;
  };
  const auto& grid = layout_.regular();
  if (!grid) {
    std::size_t first = 0;
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      if (within(i)) continue;
      take(first, i);
      first = i + 1;
    }
    take(first, layout_.size());
    return;
  }
  // Of each row of a grid a stretch about the disc's middle: its ends nearly by the root, then taxel by
  // taxel.
  const auto pitches = static_cast<float>(1 / grid->pitch_m);
  const auto left = static_cast<float>(left_m_), bottom = static_cast<float>(bottom_m_);
  const auto reach = static_cast<float>(reach_m);
  const auto index = [&](float place_m, std::size_t count) {
    const float place = std::clamp(place_m * pitches, 0.0F, static_cast<float>(count));
    return static_cast<std::size_t>(static_cast<std::int32_t>(place));
  };
  const std::size_t first_row = index(cy - reach - bottom, grid->rows);
  const std::size_t end_row = std::min(index(cy + reach - bottom, grid->rows) + 1, grid->rows);
  for (std::size_t row = first_row; row < end_row; ++row) {
    const std::size_t begin = row * grid->columns, end = begin + grid->columns;
    const float y = y_m_[begin] - cy;
    const float half = std::sqrt(std::max(0.0F, reach2 - y * y));
    std::size_t from = begin + index(cx - half - left, grid->columns);
    std::size_t to = std::min(begin + index(cx + half - left, grid->columns) + 1, end);
    while (from < to && !within(from)) ++from;
    while (to > from && !within(to - 1)) --to;
    if (from == to) continue;
    while (from > begin && within(from - 1)) --from;
    while (to < end && within(to)) ++to;
    take(from, to);
  }
}

void PatchFinder::sum_forces() noexcept {
  const ForceSums sums = kernels_.force(patch_.taxels, runs_, static_cast<float>(patch_.center_x_m),
                                        static_cast<float>(patch_.center_y_m));
  const double area = layout_.area_m2();
  patch_.normal_n = sums.p * area;
  patch_.shear_x_n = sums.x * area;
  patch_.shear_y_n = sums.y * area;
  moment_pa_m_ = sums.moment;
  squares_m2_ = sums.rr;
  patch_.peak_pa = sums.peak;
  patch_.shear_x_extreme_pa = sums.x_extreme;
  patch_.shear_y_extreme_pa = sums.y_extreme;
  patch_.shear_n = norm(patch_.shear_x_n, patch_.shear_y_n);
  patch_.finite = std::isfinite(patch_.shear_n) && std::isfinite(patch_.normal_n);
  if (patch_.shear_n > 0) {
    patch_.direction_x = patch_.shear_x_n / patch_.shear_n;
    patch_.direction_y = patch_.shear_y_n / patch_.shear_n;
  }
}

// docs/methods.md §20.4. The centre is that of the pressure, so that its noise moves the lever of Q: by half
// of the squared distances, as only those across Q count.
void PatchFinder::measure_torque() noexcept {
  const double area = layout_.area_m2(), levers_m = std::sqrt(squares_m2_);
  patch_.torque_nm = moment_pa_m_ * area;
  const double place_m = patch_.normal_n > 0 ? patch_.noise_normal_pa * area * levers_m *
                                                   std::numbers::sqrt2 / 2 / patch_.normal_n
                                             : 0;
  patch_.torque_sigma_nm = norm(patch_.noise_shear_pa * area * levers_m, place_m * patch_.shear_n);
  if (patch_.cut)
    patch_.torque_sigma_nm =
        norm(patch_.torque_sigma_nm, options_.cut_torque_share * patch_.shear_n * patch_.radius_m);
}

// Noise that taxels share does not average out over the disc.
void PatchFinder::add_shared_noise() noexcept {
  const double share = static_cast<double>(patch_.count) / static_cast<double>(layout_.size());
  patch_.normal_sigma_n = std::max(patch_.normal_sigma_n, share * noise_->normal_n);
  patch_.shear_sigma_n = std::max(patch_.shear_sigma_n, share * noise_->shear_n);
}

// Off the contact there is no shear: what is read there along the resultant is noise.
void PatchFinder::measure_shear_noise() noexcept {
  if (noise_) {
    patch_.noise_shear_pa = noise_->shear_pa;
    return;
  }
  const std::size_t off = layout_.size() - patch_.count;
  if (off < kLeastTaxels) {  // hardly a taxel is free: taken as noisy as the pressure
    patch_.noise_shear_pa = patch_.noise_normal_pa;
    return;
  }
  rest_.clear();
  std::uint32_t from = 0;
  for (const TaxelRun& run : runs_) {
    if (from < run.first) rest_.push_back({from, run.first});
    from = run.end;
  }
  if (from < layout_.size()) rest_.push_back({from, static_cast<std::uint32_t>(layout_.size())});
  const double squares = kernels_.shear_squares(patch_.taxels, rest_, patch_.pose());
  patch_.noise_shear_pa = std::sqrt(squares / static_cast<double>(off));
}

}  // namespace slipd
