#include "core/estimate/friction_belief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slipd {
namespace {

constexpr double kForgetAfterSeconds = 5;  // forces' evidence fades towards what the scene expects
constexpr double kLeastSigma = 0.02;       // of friction, relative: contacts are not as even as their model

constexpr double kRestBelow = 12, kRestAbove = 20;  // a friction below, above the likeliest keeps exp(-this)
constexpr double kMostUnexpected = 40;  // the least weight that the scene leaves a friction, as a logarithm
// Doubt in the friction believed: its contact is off by more than the model leaves open, over some frames if
// noise asks for that.
constexpr double kDoubt = 1, kNoisyDoubt = 1.6, kDoubtGain = 0.2;
constexpr double kClean =
    0.4;  // noise, of what the model leaves open: little enough to look for another friction
constexpr double kRefuted = 8;       // behind the likeliest
constexpr double kSharpest = 8;      // by which its neighbours fall behind the likeliest
constexpr double kMostOfFrame = 20;  // no single frame says more

constexpr double kBand = 1.5;         // deviations by which a force has to move before it is taken to
constexpr double kBandShare = 0.002;  // of the normal force, besides
// Deviations of a shear that tells something: were those taken that just reach above the noise, it would be
// noise that is weighed.
constexpr double kTold = 6;
constexpr double kClear = 7;      // deviations of a shear whose direction is sure
constexpr double kTurned = 0.35;  // of the shear, across its axis: it has turned
constexpr double kPast = 0.05;    // of what slipped: how well noisy forces tell the past
constexpr double kUneven = 0.02;  // of the shear: what skins that are no half space deviate
// Of Q, of mu P: as good as slipped by a load that only rose.
constexpr double kLike = 0.03, kLikeShare = 0.003;
constexpr double kStrange = 9;                 // squared misfit of a frame that no friction explains
constexpr double kByChance = 4, kChanged = 8;  // logarithms of likelihoods, a frame's and their sum
constexpr double kSurprising = 16;             // squared misfit of a frame for the friction believed so far
constexpr int kEnoughAgree = 20;  // frames, then a load that was met half-way has indeed only risen
constexpr int kBegin = 5;         // frames after which a grasp that begins has grown
constexpr double kGrown = 1.2;    // so much at least
constexpr int kMostStrange = 8;   // frames, then the history was not what it seemed
constexpr double kMemory = 0.9;   // of the misfit, frame by frame

constexpr double kOneFrame = 0.5;  // of a profile's evidence: neighbouring frames share the skin's unevenness
constexpr double kHighest = 2;     // deviations by which a load may miss the highest one
constexpr double kPlateau = 0.015;       // relative: Q/P this even while P changes is sliding
constexpr double kPlateauChange = 0.06;  // relative change of P that makes a plateau one

// Of a load that only rose, as a share of mu P: see SpringBed::slipped_n.
double risen_slipped(double gamma) noexcept {
  const double k = std::cbrt(std::clamp(gamma, 0.0, 1.0)), k3 = k * k * k;
  return 5.0 / 3 * (1 - k3) - (1 - k3 * k * k);
}

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionBelief::FrictionBelief(Range expected, double spread, bool shapeless) : shapeless_(shapeless) {
  for (std::size_t j = 0; j < kCount; ++j) {
    friction_[j] = kLow * std::pow(kHigh / kLow, static_cast<double>(j) / (kCount - 1));
    const double beyond =
        std::max({0.0, std::log(friction_[j] / expected.high), std::log(expected.low / friction_[j])});
    prior_[j] = std::max(-0.5 * square(beyond / spread), -kMostUnexpected);
  }
  reset();
}

void FrictionBelief::reset() noexcept {
  weight_ = prior_;
  for (auto& contact : contact_) contact.clear();
  shape_.fill({});
  normal_n_ = shear_n_ = axis_x_ = axis_y_ = 0;
  known_ = only_risen_ = true;
  aimed_n_ = 0;
  surprised_ = doubted_ = false;
  agreeing_ = 0;
  misfit_ = 1;
  change_ = off_slipped_n_ = off_hollow_n_ = 0;
  strange_ = frames_ = 0;
  last_ns_ = 0;
  highest_load_ = slide_normal_n_ = slide_load_ = 0;
}

void FrictionBelief::update(std::int64_t time_ns, const ContactPatch& patch,
                            const Reading* reading) noexcept {
  const double passed_s = last_ns_ > 0 ? static_cast<double>(time_ns - last_ns_) * 1e-9 : 0;
  last_ns_ = time_ns;
  const double load = patch.shear_n / patch.normal_n, load_sigma = patch.shear_sigma_n / patch.normal_n;
  const double keep = shapeless_ ? std::exp(-std::max(0.0, passed_s) / kForgetAfterSeconds) : 1;
  const double sigma = std::max(load_sigma, 0.01 * load);
  for (std::size_t j = 0; j < kCount; ++j) {
    weight_[j] = prior_[j] + keep * (weight_[j] - prior_[j]);
    const double over = (load - friction_[j]) / sigma;  // more is carried than this friction could hold
    if (over > 0) weight_[j] -= std::min(0.5 * over * over, kMostOfFrame);
  }
  if (!shapeless_) {
    follow(patch);
    watch_begin(patch);
  }
  surprised_ = doubted_ = false;
  if (reading != nullptr && patch.shear_n > kTold * patch.shear_sigma_n) weigh_shape(patch, *reading);
  if (shapeless_) weigh_sliding(patch.normal_n, load, load_sigma);
  normalise();
}

// Tells the contacts what the forces did, noise left out: a force that only trembles would be a reversal a
// frame.
void FrictionBelief::follow(const ContactPatch& patch) noexcept {
  // Which way it goes is the surer the more there is of it: until it is clear the axis follows, later with
  // each half as much again.
  const double clear_n = kClear * patch.shear_sigma_n;
  const double across_n = std::fabs(patch.shear_y_n * axis_x_ - patch.shear_x_n * axis_y_);
  const bool turned = across_n > clear_n && across_n > kTurned * patch.shear_n;
  if (patch.shear_n > std::max(1.5 * aimed_n_, 3 * patch.shear_sigma_n) || aimed_n_ < clear_n || turned) {
    const bool back = patch.toward_x * axis_x_ + patch.toward_y * axis_y_ < 0 && !turned;
    axis_x_ = back ? -patch.toward_x : patch.toward_x;
    axis_y_ = back ? -patch.toward_y : patch.toward_y;
    if (turned && aimed_n_ > clear_n) {
      shear_n_ = patch.shear_n;
      start_anew();
    }
    aimed_n_ = patch.shear_n;
  }
  const double shear = patch.shear_x_n * axis_x_ + patch.shear_y_n * axis_y_;
  const auto drag = [](double from, double to, double band) {
    return to > from + band ? to - band : (to < from - band ? to + band : from);
  };
  const double normal_sigma = patch.noise_normal_pa > 0 && patch.noise_shear_pa > 0
                                  ? patch.shear_sigma_n * patch.noise_normal_pa / patch.noise_shear_pa
                                  : patch.shear_sigma_n;
  const double still = kBandShare * patch.normal_n;
  const double normal_to = drag(normal_n_, patch.normal_n, kBand * normal_sigma + still);
  const double shear_to = drag(shear_n_, shear, kBand * patch.shear_sigma_n + 0.1 * still);
  if (normal_to == normal_n_ && shear_to == shear_n_) return;
  normal_n_ = std::max(normal_to, 1e-6 * patch.normal_n);
  shear_n_ = shear_to;
  for (std::size_t j = 0; j < kCount; ++j) {
    contact_[j].follow(normal_n_, shear_n_, friction_[j]);
    shape_[j] = contact_[j].shape();
  }
}

// A grasp begins with little force, and grows. One that is met as it is was begun before: its past is not
// known.
void FrictionBelief::watch_begin(const ContactPatch& patch) noexcept {
  if (frames_ >= kBegin) return;
  if (frames_++ == 0) first_normal_n_ = patch.normal_n;
  const bool loaded = patch.shear_n > kClear * patch.shear_sigma_n;
  if (frames_ == kBegin && loaded && patch.normal_n < kGrown * first_normal_n_) start_anew();
}

// The past is not known: taken for a load that only rose until frames say otherwise.
void FrictionBelief::start_anew() noexcept {
  weight_ = prior_;
  known_ = false;
  agreeing_ = 0;
  for (std::size_t j = 0; j < kCount; ++j) {
    contact_[j].assume_risen(normal_n_, shear_n_, friction_[j]);
    shape_[j] = contact_[j].shape();
  }
}

// The likeliest friction's contact, as near as frames can tell.
bool FrictionBelief::looks_risen(double normal_n, double load) const noexcept {
  const std::size_t j = best();
  const double most_n = friction_[j] * normal_n, risen_n = most_n * risen_slipped(1 - load / friction_[j]);
  return std::fabs(std::fabs(shape_[j].slipped_n) - risen_n) < kLike * load * normal_n + kLikeShare * most_n;
}

// A friction lower than what has been seen to hold was not there all along: if it is now, then it has just
// fallen, and its contact is the one believed in, as far as less friction still holds it.
void FrictionBelief::weaken(std::size_t believed) noexcept {
  for (std::size_t j = 0; j < believed; ++j) {
    if (weight_[j] > -kRefuted) continue;
    contact_[j] = contact_[believed];
    contact_[j].follow(normal_n_, shear_n_, friction_[j]);
    shape_[j] = contact_[j].shape();
  }
}

void FrictionBelief::weigh_shape(const ContactPatch& patch, const Reading& reading) noexcept {
  const double load = patch.shear_n / patch.normal_n;
  const std::size_t believed = best();
  const bool highest = load > highest_load_ - kHighest * patch.shear_sigma_n / patch.normal_n;
  only_risen_ = shapeless_ ? highest : looks_risen(patch.normal_n, load);
  PerFriction misfit;
  const bool direct = only_risen_ && reading.in_family;
  if (direct && reading.profile.known) {
    for (std::size_t j = 0; j < kCount; ++j)
      misfit[j] = kOneFrame * 2 * reading.profile.at(1 - load / friction_[j]);
  } else if (direct) {
    const double apart =
        0.35 * std::log(kHigh / kLow) / (kCount - 1);  // so that the right one may lie between
    for (std::size_t j = 0; j < kCount; ++j) {
      const double mobilised = load / friction_[j];
      misfit[j] = square(reading.gamma - 1 + mobilised) / (square(reading.sigma) + square(apart * mobilised));
    }
  } else if (known_ && !shapeless_ && std::isfinite(reading.shape_sigma.slipped_n)) {
    const double along = patch.toward_x * axis_x_ + patch.toward_y * axis_y_;
    // What the model itself leaves open is the same in every frame: within that a frame tells nothing.
    const double locked = std::max(std::fabs(reading.shape.slipped_n), std::fabs(reading.shape.hollow_n));
    const double open = std::hypot(kUneven * patch.shear_n, kPast * locked);
    const double off_slipped = reading.shape.slipped_n - along * shape_[believed].slipped_n,
                 off_hollow = reading.shape.hollow_n - along * shape_[believed].hollow_n;
    const bool clean = std::max(reading.shape_sigma.slipped_n, reading.shape_sigma.hollow_n) < kClean * open;
    const double gain = clean ? 1 : kDoubtGain;
    off_slipped_n_ += gain * (off_slipped - off_slipped_n_);
    off_hollow_n_ += gain * (off_hollow - off_hollow_n_);
    doubted_ =
        std::max(std::fabs(off_slipped_n_), std::fabs(off_hollow_n_)) > (clean ? kDoubt : kNoisyDoubt) * open;
    if (doubted_ && clean) weaken(believed);
    const auto part = [open](double off, double sigma) {
      return square(std::max(0.0, std::fabs(off) - open)) / (square(sigma) + square(0.5 * open));
    };
    for (std::size_t j = 0; j < kCount; ++j) {
      misfit[j] = part(reading.shape.slipped_n - along * shape_[j].slipped_n, reading.shape_sigma.slipped_n) +
                  part(reading.shape.hollow_n - along * shape_[j].hollow_n, reading.shape_sigma.hollow_n);
    }
  } else {
    return;
  }
  surprised_ = misfit[believed] > kSurprising;
  // Friction has changed when frame after frame says so: what older frames told of it goes.
  change_ = std::max(0.0, change_ + 0.5 * misfit[believed] - kByChance);
  const double least = *std::min_element(misfit.begin(), misfit.end());
  misfit_ = kMemory * misfit_ + (1 - kMemory) * std::min(least, 4 * kStrange);
  if (least > kStrange) {
    if (++strange_ >= kMostStrange) {
      strange_ = 0;
      start_anew();
    }
    return;
  }
  strange_ = 0;
  if (change_ > kChanged) {
    change_ = 0;
    weight_ = prior_;
  }
  if (direct) known_ = known_ || ++agreeing_ >= kEnoughAgree;
  for (std::size_t j = 0; j < kCount; ++j) weight_[j] -= std::min(0.5 * (misfit[j] - least), kMostOfFrame);
}

// Coulomb: an object that slides keeps Q/P while P changes. (While both grow from nothing a stuck contact
// does so too.)
void FrictionBelief::weigh_sliding(double normal_n, double load, double load_sigma) noexcept {
  highest_load_ = std::max(highest_load_, load - load_sigma);
  const bool even = std::fabs(load - slide_load_) < kPlateau * slide_load_ + 2 * load_sigma;
  if (!even || slide_load_ == 0 || normal_n > slide_normal_n_) {
    slide_load_ = load;
    slide_normal_n_ = normal_n;
    return;
  }
  if (normal_n > (1 - kPlateauChange) * slide_normal_n_ || load < 0.9 * highest_load_) return;
  for (std::size_t j = 0; j < kCount; ++j) {
    const double off = std::log(friction_[j] / load) / (3 * kPlateau);
    weight_[j] -= kOneFrame * 0.5 * std::min(off * off, 25.0);
  }
}

std::size_t FrictionBelief::best() const noexcept {
  return static_cast<std::size_t>(std::max_element(weight_.begin(), weight_.end()) - weight_.begin());
}

void FrictionBelief::normalise() noexcept {
  const std::size_t top = best();
  const double most = weight_[top];
  const double beside =
      std::max(top > 0 ? weight_[top - 1] : -1e300, top + 1 < kCount ? weight_[top + 1] : -1e300);
  const double soften = std::min(1.0, kSharpest / (most - beside + 1e-9));
  for (std::size_t j = 0; j < kCount; ++j)
    weight_[j] = std::max(soften * (weight_[j] - most), prior_[j] - (j < top ? kRestBelow : kRestAbove));
}

FrictionBelief::Value FrictionBelief::friction() const noexcept {
  const std::size_t top = best();
  double sum = 0, mean = 0, squares = 0, near = 0;
  for (std::size_t j = 0; j < kCount; ++j) {
    const double w = std::exp(weight_[j]);
    sum += w;
    mean += w * friction_[j];
    squares += w * square(friction_[j]);
    if (j + 2 >= top && j <= top + 2) near += w;
  }
  mean /= sum;
  Value value{mean, std::sqrt(std::max(0.0, squares / sum - mean * mean))};
  if (top > 0 && top + 1 < kCount && near > 0.97 * sum) {  // as sharp as the grid: a parabola about the top
    const double below = weight_[top - 1], above = weight_[top + 1], curve = -below - above;
    const double apart = std::log(kHigh / kLow) / (kCount - 1);
    if (curve > 0.5) {
      value.mean = friction_[top] * std::exp(0.5 * apart * (above - below) / curve);
      value.sigma = value.mean * apart / std::sqrt(curve);
    }
  }
  value.sigma = std::hypot(value.sigma, kLeastSigma * value.mean);
  return value;
}

FrictionBelief::Value FrictionBelief::margin(double load, double load_sigma) const noexcept {
  const Value mu = friction();
  if (mu.sigma < 0.1 * mu.mean) {
    const double mobilised = load / mu.mean;
    return {std::clamp(1 - mobilised, 0.0, 1.0), std::hypot(mobilised * mu.sigma, load_sigma) / mu.mean};
  }
  double sum = 0, mean = 0, squares = 0;
  for (std::size_t j = 0; j < kCount; ++j) {
    const double w = std::exp(weight_[j]), gamma = std::clamp(1 - load / friction_[j], 0.0, 1.0);
    sum += w;
    mean += w * gamma;
    squares += w * gamma * gamma;
  }
  mean /= sum;
  const double mobilised = 1 - mean, step = std::log(kHigh / kLow) / (kCount - 1) * mobilised;
  return {mean, std::sqrt(std::max(0.0, squares / sum - mean * mean) + step * step / 12 +
                          square(load_sigma * mobilised / std::max(load, 1e-9)))};
}

}  // namespace slipd
