#include "tools/sliplab/skin/depth.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/reading/fit/subsurface_fit.hpp"

namespace sliplab {
namespace {

using namespace slipd;

// Depths of one search, evenly in their logarithm.
constexpr std::size_t kDepths = 13;
// Searches, each between the neighbours of the last one's best.
constexpr int kSearches = 2;
// Below this share of a taxel's side a skin is the surface, see with_sensed_skin in
// core/chain/chain_parts.cpp.
constexpr double kThinnestSides = 1.0 / 9;
// Presses without which no depth is told: one or two may as well be edges or objects that are no spheres.
constexpr std::size_t kLeastPresses = 3;
// The deepest that is tried, over the greatest radius sensed.
constexpr double kDeepestRadii = 1;

struct Search {
  double from_m, to_m;
  double step() const { return std::log(to_m / from_m) / (kDepths - 1); }
  double depth_m(std::size_t i) const { return from_m * std::exp(step() * static_cast<double>(i)); }
};

// What the frames say of each depth of a search, nats; NaN where a frame could not be fitted.
struct Misfits {
  std::vector<std::vector<double>> of_frame;  // by frame and depth
  std::vector<double> sum;
  std::size_t best = 0;
};

class DepthTrial {
 public:
  DepthTrial(const TaxelLayout& layout, Range friction, const std::vector<PressFrame>& presses,
             std::optional<double> bonded_poisson)
      : layout_(layout), friction_(friction), presses_(presses), bonded_poisson_(bonded_poisson) {}

  // The same taxels at all depths: those that the deepest reaches.
  SubsurfaceFit fit_at(double depth_m, double reach_m) const {
    return {layout_, friction_, depth_m, {}, {.reach_depths = reach_m / depth_m}, 0, bonded_poisson_};
  }

  Misfits measure(const Search& search, double reach_m) const {
    Misfits out{.of_frame = std::vector(presses_.size(), std::vector(kDepths, 0.0)),
                .sum = std::vector(kDepths, 0.0)};
    PatchFinder finder(layout_);
    for (std::size_t i = 0; i < kDepths; ++i) {
      SubsurfaceFit fit = fit_at(search.depth_m(i), reach_m);
      for (std::size_t j = 0; j < presses_.size(); ++j) {
        const PressFrame& press = presses_[j];
        const ContactPatch& patch = finder.find({1, 1, press.normal_pa, press.shear_x_pa, press.shear_y_pa});
        static_cast<void>(fit.estimate(patch, moment_ratio(patch, layout_)));
        out.of_frame[j][i] = fit.misfit_nats();
      }
    }
    for (const auto& frame : out.of_frame) {
      if (!std::all_of(frame.begin(), frame.end(), [](double x) { return std::isfinite(x); })) continue;
      ++used_;
      for (std::size_t i = 0; i < kDepths; ++i) out.sum[i] += frame[i];
    }
    out.best = static_cast<std::size_t>(std::min_element(out.sum.begin(), out.sum.end()) - out.sum.begin());
    return out;
  }

  std::size_t take_used() const noexcept { return std::exchange(used_, 0); }

 private:
  const TaxelLayout& layout_;
  Range friction_;
  const std::vector<PressFrame>& presses_;
  std::optional<double> bonded_poisson_;
  mutable std::size_t used_ = 0;
};

// The lowest point of the parabola through three even points about the least, in steps from the first, and
// its second derivative.
struct Parabola {
  double at = 0, curvature = 0;
};
std::optional<Parabola> parabola_at(const std::vector<double>& nats) {
  const auto least = std::min_element(nats.begin(), nats.end()) - nats.begin();
  if (least == 0 || least + 1 == static_cast<std::ptrdiff_t>(nats.size())) return std::nullopt;
  const auto i = static_cast<std::size_t>(least);
  const double curvature = nats[i + 1] - 2 * nats[i] + nats[i - 1];
  if (!(curvature > 0)) return std::nullopt;
  return Parabola{static_cast<double>(i) - 0.5 * (nats[i + 1] - nats[i - 1]) / curvature, curvature};
}

// Of all frames' taxels under clear pressure.
std::optional<double> gain_spread_of(const TaxelLayout& layout, SubsurfaceFit fit,
                                     const std::vector<PressFrame>& presses) {
  constexpr double kLeastPressure = 0.2;  // of the frame's peak
  constexpr std::size_t kLeastTaxels = 8;
  std::vector<double> products(layout.size()), squares(layout.size()), noise(layout.size());
  PatchFinder finder(layout);
  for (const PressFrame& press : presses) {
    const ContactPatch& patch = finder.find({1, 1, press.normal_pa, press.shear_x_pa, press.shear_y_pa});
    if (!fit.estimate(patch, moment_ratio(patch, layout)).in_model) continue;
    const ContactShape& model = fit.model();
    for (std::size_t j = 0; j < model.count(); ++j) {
      const double sensed = model.data_pa()[j], noise_pa = patch.noise_normal_pa,
                   fitted = sensed + model.residuals()[j] * model.noise().normal_pa;
      if (fitted < kLeastPressure * patch.peak_pa) continue;
      const std::size_t i = model.taxels()[j];
      products[i] += sensed * fitted;
      squares[i] += fitted * fitted;
      noise[i] += noise_pa * noise_pa * fitted * fitted;
    }
  }
  double count = 0, mean = 0, square = 0, by_noise = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (!(squares[i] > 0)) continue;
    const double gain = products[i] / squares[i];
    count += 1;
    mean += gain;
    square += gain * gain;
    by_noise += noise[i] / (squares[i] * squares[i]);
  }
  if (count < static_cast<double>(kLeastTaxels)) return std::nullopt;
  mean /= count;
  return std::sqrt(std::max(0.0, square / count - mean * mean - by_noise / count)) / mean;
}

}  // namespace

std::vector<PressFrame> press_frames(const TaxelLayout& layout, const std::vector<PressFrame>& frames,
                                     std::size_t most) {
  constexpr double kLeastForce = 1.0 / 3;  // of the greatest
  PatchFinder finder(layout);
  std::vector<double> force_n;
  force_n.reserve(frames.size());
  for (const PressFrame& frame : frames) {
    const ContactPatch& patch = finder.find({1, 1, frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa});
    force_n.push_back(patch.in_contact && patch.finite && !patch.cut ? patch.normal_n : 0);
  }
  const double greatest = force_n.empty() ? 0 : *std::max_element(force_n.begin(), force_n.end());
  std::vector<std::size_t> pressed;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (greatest > 0 && force_n[i] >= kLeastForce * greatest) pressed.push_back(i);
  }
  std::vector<PressFrame> out;
  const std::size_t count = std::min(most, pressed.size());
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(frames[pressed[(2 * i + 1) * pressed.size() / (2 * count)]]);
  return out;
}

std::optional<SkinDepth> skin_depth(const TaxelLayout& layout, Range friction_expected,
                                    const std::vector<PressFrame>& presses,
                                    std::optional<double> bonded_poisson) {
  double radius_m = 0;
  PatchFinder finder(layout);
  for (const PressFrame& press : presses)
    radius_m =
        std::max(radius_m, finder.find({1, 1, press.normal_pa, press.shear_x_pa, press.shear_y_pa}).radius_m);
  const double thinnest_m = kThinnestSides * layout.side_m(), deepest_m = kDeepestRadii * radius_m;
  if (presses.size() < kLeastPresses || !(deepest_m > 2 * thinnest_m)) return std::nullopt;
  const double reach_m = 0.5 * radius_m;
  const DepthTrial trial(layout, friction_expected, presses, bonded_poisson);
  Search search{thinnest_m, deepest_m};
  Misfits misfits;
  SkinDepth out;
  for (int i = 0; i < kSearches; ++i) {
    if (i > 0) search = {search.depth_m(misfits.best - 1), search.depth_m(misfits.best + 1)};
    misfits = trial.measure(search, reach_m);
    out.frames = trial.take_used();
    if (out.frames == 0) return std::nullopt;
    if (i == 0 && misfits.best == 0) return out;  // at the surface
    if (misfits.best == 0 || misfits.best + 1 == kDepths) break;
  }
  const auto best = parabola_at(misfits.sum);
  if (!best) return std::nullopt;
  const double step = search.step();
  out.depth_m = search.from_m * std::exp(step * best->at);
  out.misfit_nats = misfits.sum[misfits.best];
  const double by_noise = step / std::sqrt(best->curvature);
  double count = 0, mean = 0, square = 0;
  for (const auto& frame : misfits.of_frame) {
    const auto own = parabola_at(frame);
    if (!own) continue;
    count += 1;
    mean += own->at;
    square += own->at * own->at;
  }
  const double scatter =
      count > 1
          ? step * std::sqrt(std::max(0.0, square / count - mean * mean / (count * count)) / (count - 1))
          : 0;
  out.sigma_m = out.depth_m * std::max(by_noise, scatter);
  out.gain_spread = gain_spread_of(layout, trial.fit_at(out.depth_m, reach_m), presses);
  return out;
}

}  // namespace sliplab
