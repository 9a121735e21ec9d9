#include "core/load/steady_load.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

ContactForces operator+(const ContactForces& a, const ContactForces& b) noexcept {
  return {a.normal_n + b.normal_n, a.shear_x_n + b.shear_x_n, a.shear_y_n + b.shear_y_n};
}

ContactForces operator*(double factor, const ContactForces& a) noexcept {
  return {factor * a.normal_n, factor * a.shear_x_n, factor * a.shear_y_n};
}

ContactForces operator-(const ContactForces& a, const ContactForces& b) noexcept {
  return a + -1.0 * b;
}

// Of one frame, N^2.
struct NoiseVariance {
  double normal, shear;
};

// The larger of the squares of P and of shear, each over this share of a frame's variance. Nothing without
// noise is no change.
double squared_sigmas(const ContactForces& of, double share, const NoiseVariance& noise) noexcept {
  const double normal = square(of.normal_n), shear = square(of.shear_x_n) + square(of.shear_y_n);
  return std::max(normal > 0 ? normal / (share * noise.normal) : 0,
                  shear > 0 ? shear / (share * noise.shear) : 0);
}

// Through frames that are numbered from 1 on.
struct Line {
  double frames = 0, middle = 0;  // how many, and the number of the one in the middle
  ContactForces mean, slope;      // N, and N a frame; 0 where noise explains it
  double slope_variance = 0;      // of one frame's
  ContactForces at(double frame) const noexcept { return mean + (frame - middle) * slope; }
  double variance_at(double frame) const noexcept {
    return 1 / frames + square(frame - middle) * slope_variance;
  }
};

// Least squares. What a load that is held cannot have as a slope would be followed to and fro.
Line line_of(const ContactForces& sum, const ContactForces& sum_by_frame, std::size_t frames,
             const NoiseVariance& noise) noexcept {
  const auto n = static_cast<double>(frames);
  Line line{.frames = n, .middle = 0.5 * (n + 1), .mean = 1 / n * sum, .slope = {}};
  if (frames < 2) return line;
  const double per_square = 12 / (n * (square(n) - 1));
  const ContactForces slope = per_square * (sum_by_frame - line.middle * sum);
  if (!(squared_sigmas(slope, per_square, noise) > square(kClearSigmas))) return line;
  line.slope = slope;
  line.slope_variance = per_square;
  return line;
}

}  // namespace

// What came before these frames is forgotten. (Sums of a long hold are large: what is left of them has no
// more digits than each frame's forces.)
void SteadyLoad::begin_with_latest(std::size_t frames) noexcept {
  ContactForces last = sums_before(frames).forces;
  Sums since;
  sums_before(frames) = since;
  for (std::size_t i = 1; i <= frames; ++i) {
    Sums& sums = sums_before(frames - i);
    const ContactForces forces = sums.forces - last;
    last = sums.forces;
    since = {since.forces + forces, since.by_frame + static_cast<double>(i) * forces};
    sums = since;
  }
  frames_ = frames;
}

void SteadyLoad::follow(const ContactForces& forces, double normal_sigma_n, double shear_sigma_n) noexcept {
  const NoiseVariance noise{square(normal_sigma_n), square(shear_sigma_n)};
  const Sums before = sums_before(0);
  ++newest_;
  ++frames_;
  const auto newest = static_cast<double>(frames_);
  Sums& sums = sums_before(0);
  sums = {before.forces + forces, before.by_frame + newest * forces};
  double most = square(kStandsOutSigmas);
  std::size_t turned = 0;
  for (std::size_t latest = 1; latest <= kLongest && latest < frames_; latest *= 2) {
    const auto n = static_cast<double>(latest);
    const Sums& earlier = sums_before(latest);
    const Line line = line_of(earlier.forces, earlier.by_frame, frames_ - latest, noise);
    const double middle = newest - 0.5 * (n - 1), variance = 1 / n + line.variance_at(middle);
    const ContactForces off = 1 / n * (sums.forces - earlier.forces) - line.at(middle);
    const double apart = squared_sigmas(off, variance, noise);
    if (!(apart > most)) continue;
    most = apart;
    turned = latest;
  }
  if (turned > 0) begin_with_latest(turned);
  const Line line = line_of(sums.forces, sums.by_frame, frames_, noise);
  now_ = line.at(line.frames);
  noise_share_ = std::sqrt(line.variance_at(line.frames));
  if (now_.normal_n > 0) return;
  begin_with_latest(1);  // a line that falls runs ahead of a load that does no longer
  now_ = forces;
  noise_share_ = 1;
}

}  // namespace slipd
