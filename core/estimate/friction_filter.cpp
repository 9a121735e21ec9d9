#include "core/estimate/friction_filter.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

constexpr double kForgetAfterSeconds = 5;  // what forces alone told fades towards what the scene expects

// Forces. Deviations by which one has to move before it is taken to, and a share of the normal force besides.
constexpr double kBand = 1.5, kBandShare = 0.002;
constexpr double kClear = 7;      // deviations of a shear whose direction is sure
constexpr double kTurned = 0.35;  // of the shear, across its axis: it has turned
constexpr int kBegin = 5;         // frames after which a grasp that begins has grown
constexpr double kGrown = 1.2;    // so much at least

// Frames. Deviations of a shear that tells something: were those taken that just reach above the noise, it
// would be noise that is weighed.
constexpr double kTold = 6;
constexpr double kBetween = 0.35;  // of the grid's step, so that the right friction may lie between two
constexpr double kPast = 0.04;     // of what is locked in: how well noisy forces tell the past
constexpr double kUneven = 0.02;   // of the shear: what skins that are no half space deviate
constexpr double kLike = 0.03,
                 kLikeShare = 0.003;  // of Q, of mu P: as good as slipped by a load that only rose

// Judgement, by squared misfits.
constexpr double kStrange = 9;                 // of a frame that no friction explains
constexpr int kMostStrange = 8;                // frames, then the history was not what it seemed
constexpr double kMemory = 0.9;                // of the misfit, frame by frame
constexpr double kSurprising = 16;             // for the friction believed so far
constexpr double kByChance = 4, kChanged = 8;  // logarithms of likelihoods, a frame's and their sum
constexpr int kEnoughAgree = 20;  // frames, then a load that was met half-way has indeed only risen
// Doubt in the friction believed: its contact is off by more than the model leaves open, over some frames if
// noise asks for that. Clean: so little noise, of what is left open, that another friction can be looked for.
constexpr double kDoubt = 1, kNoisyDoubt = 1.6, kDoubtGain = 0.2, kClean = 0.4;
constexpr int kSettled = 10;  // frames, then the weights have found that other friction
// Of log mu. No friction changes so much at once, but noise may turn one belief into another.
constexpr double kJumped = 0.4;

// Of profiles' evidence: neighbouring frames share the skin's unevenness, so that each counts for half. What
// noise makes of the contact's place and size draws all of them the same way, the more so the less they tell:
// after n frames of a deviation sigma the next one counts for 1 / (1 + n (sigma/kAlike)^2) of that.
constexpr double kOneFrame = 0.5;
constexpr double kAlike = 1.2;

// Of a load that only rose, as a share of mu P: see ShearMoments::slip_moment_n.
double monotonic_slip_moment(double gamma) noexcept {
  const double k = std::cbrt(std::clamp(gamma, 0.0, 1.0)), k3 = k * k * k;
  return 5.0 / 3 * (1 - k3) - (1 - k3 * k * k);
}

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionFilter::FrictionFilter(Range expected, double spread, bool force_only)
    : weights_(expected, spread, force_only ? kForceOnly : kContacts),
      force_only_(force_only),
      carried_(force_only),
      contacts_(weights_.frictions().first(kContacts)) {}

void FrictionFilter::reset() noexcept {
  weights_.reset();
  contacts_.clear();
  normal_n_ = shear_n_ = axis_x_ = axis_y_ = 0;
  known_ = monotonic_ = true;
  aimed_n_ = told_ = 0;
  surprised_ = false;
  agreeing_ = doubted_ = 0;
  misfit_ = 1;
  cusum_ = off_slip_moment_n_ = off_second_legendre_n_ = 0;
  strange_ = frames_ = 0;
  last_ns_ = 0;
  carried_.clear();
  believed_ = 0;
}

void FrictionFilter::update(std::int64_t time_ns, const ContactPatch& patch,
                            const FrameEstimate* frame_estimate) noexcept {
  const double passed_s = last_ns_ > 0 ? static_cast<double>(time_ns - last_ns_) * 1e-9 : 0;
  last_ns_ = time_ns;
  carried_.update(patch);
  const auto [held, counts] = carried_.held();
  if (force_only_) weights_.fade(std::exp(-std::max(0.0, passed_s) / kForgetAfterSeconds));
  for (std::size_t j = 0; j < weights_.count(); ++j) {
    const double over = (held.mean - weights_.friction(j)) / held.sigma;  // more than this one could hold
    if (over > 0) weights_.take(j, counts * 0.5 * over * over);
  }
  if (!force_only_) {
    follow(patch);
    watch_begin(patch);
  }
  surprised_ = false;
  doubted_ = std::max(0, doubted_ - 1);
  if (frame_estimate != nullptr && patch.shear_n > kTold * patch.shear_sigma_n)
    weigh_frame(patch, *frame_estimate);
  if (force_only_) {
    if (const auto slides = carried_.look_for_sliding()) weigh_sliding(*slides);
  }
  weights_.normalise();
  if (!force_only_) watch_jumps();
}

// What has just been something else altogether is told only when it has stood for a while.
void FrictionFilter::watch_jumps() noexcept {
  const double believed = weights_.friction(weights_.likeliest());
  if (believed_ > 0 && std::fabs(std::log(believed / believed_)) > kJumped) doubted_ = kSettled;
  believed_ = believed;
}

// Tells the contacts what the forces did, noise left out: a force that only trembles would be a reversal a
// frame.
void FrictionFilter::follow(const ContactPatch& patch) noexcept {
  // Which way it goes is the surer the more there is of it: until it is clear the axis follows, later with
  // each half as much again.
  const double clear_n = kClear * patch.shear_sigma_n;
  const double across_n = std::fabs(patch.shear_y_n * axis_x_ - patch.shear_x_n * axis_y_);
  const bool turned = across_n > clear_n && across_n > kTurned * patch.shear_n;
  if (patch.shear_n > std::max(1.5 * aimed_n_, 3 * patch.shear_sigma_n) || aimed_n_ < clear_n || turned) {
    const bool back = patch.direction_x * axis_x_ + patch.direction_y * axis_y_ < 0 && !turned;
    axis_x_ = back ? -patch.direction_x : patch.direction_x;
    axis_y_ = back ? -patch.direction_y : patch.direction_y;
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
  const double still = kBandShare * patch.normal_n;
  const double normal_to = drag(normal_n_, patch.normal_n, kBand * patch.normal_sigma_n + still);
  const double shear_to = drag(shear_n_, shear, kBand * patch.shear_sigma_n + 0.1 * still);
  if (normal_to == normal_n_ && shear_to == shear_n_) return;
  normal_n_ = std::max(normal_to, 1e-6 * patch.normal_n);
  shear_n_ = shear_to;
  contacts_.follow(normal_n_, shear_n_);
}

// A grasp begins with little force, and grows. One that is met as it is was begun before: its past is not
// known.
void FrictionFilter::watch_begin(const ContactPatch& patch) noexcept {
  if (frames_ >= kBegin) return;
  if (frames_++ == 0) first_normal_n_ = patch.normal_n;
  const bool loaded = patch.shear_n > kClear * patch.shear_sigma_n;
  if (frames_ == kBegin && loaded && patch.normal_n < kGrown * first_normal_n_) start_anew();
}

// The past is not known: taken for a load that only rose until frames say otherwise.
void FrictionFilter::start_anew() noexcept {
  weights_.reset();
  told_ = 0;
  known_ = false;
  agreeing_ = 0;
  if (!force_only_) contacts_.assume_monotonic(normal_n_, shear_n_);
}

// The likeliest friction's contact, as near as frames can tell.
bool FrictionFilter::looks_monotonic(double normal_n, double load) const noexcept {
  const std::size_t j = weights_.likeliest();
  const double most_n = weights_.friction(j) * normal_n,
               risen_n = most_n * monotonic_slip_moment(1 - load / weights_.friction(j));
  return std::fabs(std::fabs(contacts_.shear_moments(j).slip_moment_n) - risen_n) <
         kLike * load * normal_n + kLikeShare * most_n;
}

// A friction lower than what has been seen to hold was not there all along: if it is now, then it has just
// fallen, and its contact is the one believed in, as far as less friction still holds it.
void FrictionFilter::weaken() noexcept {
  contacts_.weaken(weights_.likeliest(), [this](std::size_t j) { return weights_.refuted(j); });
}

void FrictionFilter::weigh_frame(const ContactPatch& patch, const FrameEstimate& frame_estimate) noexcept {
  const double load = patch.shear_n / patch.normal_n;
  monotonic_ = force_only_ ? carried_.is_highest(load, patch.shear_sigma_n / patch.normal_n)
                           : looks_monotonic(patch.normal_n, load);
  const bool direct = monotonic_ && frame_estimate.in_model;
  PerFriction misfit;  // of as many as there are
  if (direct) {
    misfit_of_margin(load, frame_estimate, misfit);
    told_ += square(frame_estimate.sigma / kAlike);
  } else if (known_ && !force_only_ && std::isfinite(frame_estimate.moments_sigma.slip_moment_n)) {
    misfit_of_shear_moments(patch, frame_estimate, misfit);
  } else {
    return;
  }
  judge(misfit, direct);
}

void FrictionFilter::misfit_of_margin(double load, const FrameEstimate& frame_estimate,
                                      PerFriction& misfit) const noexcept {
  const double apart = kBetween * weights_.step();
  const double new_in_it = kOneFrame / (1 + told_);
  for (std::size_t j = 0; j < weights_.count(); ++j) {
    const double mobilised = load / weights_.friction(j);
    misfit[j] = frame_estimate.profile.known ? new_in_it * 2 * frame_estimate.profile.at(1 - mobilised)
                                             : square(frame_estimate.gamma - 1 + mobilised) /
                                                   (square(frame_estimate.sigma) + square(apart * mobilised));
  }
}

void FrictionFilter::misfit_of_shear_moments(const ContactPatch& patch, const FrameEstimate& frame_estimate,
                                             PerFriction& misfit) noexcept {
  const contact::ShearMoments &seen = frame_estimate.moments, &noise = frame_estimate.moments_sigma;
  const double along = patch.direction_x * axis_x_ + patch.direction_y * axis_y_;
  // What the model itself leaves open is the same in every frame: within that a frame tells nothing.
  const double locked = std::max(std::fabs(seen.slip_moment_n), std::fabs(seen.second_legendre_n));
  const double open = std::hypot(kUneven * patch.shear_n, kPast * locked);

  const bool clean = std::max(noise.slip_moment_n, noise.second_legendre_n) < kClean * open;
  const double gain = clean ? 1 : kDoubtGain;
  const auto believed = contacts_.shear_moments(weights_.likeliest());
  off_slip_moment_n_ += gain * (seen.slip_moment_n - along * believed.slip_moment_n - off_slip_moment_n_);
  off_second_legendre_n_ +=
      gain * (seen.second_legendre_n - along * believed.second_legendre_n - off_second_legendre_n_);
  if (std::max(std::fabs(off_slip_moment_n_), std::fabs(off_second_legendre_n_)) >
      (clean ? kDoubt : kNoisyDoubt) * open) {
    doubted_ = std::max(doubted_, clean ? kSettled : 1);
    if (clean) weaken();
  }

  const auto part = [open](double off, double sigma) {
    return square(std::max(0.0, std::fabs(off) - open)) / (square(sigma) + square(0.5 * open));
  };
  for (std::size_t j = 0; j < weights_.count(); ++j) {
    const auto expected = contacts_.shear_moments(j);
    misfit[j] = part(seen.slip_moment_n - along * expected.slip_moment_n, noise.slip_moment_n) +
                part(seen.second_legendre_n - along * expected.second_legendre_n, noise.second_legendre_n);
  }
}

// Takes weight from what explains the frame badly, unless nothing explains it.
void FrictionFilter::judge(const PerFriction& misfit, bool direct) noexcept {
  const double believed = misfit[weights_.likeliest()];
  const double least =
      *std::min_element(misfit.begin(), misfit.begin() + static_cast<std::ptrdiff_t>(weights_.count()));
  surprised_ = believed > kSurprising;
  misfit_ = kMemory * misfit_ + (1 - kMemory) * std::min(least, 4 * kStrange);
  // Friction has changed when frame after frame says so: what older frames told of it goes.
  cusum_ = std::max(0.0, cusum_ + 0.5 * believed - kByChance);
  if (least > kStrange) {
    if (++strange_ >= kMostStrange) {
      strange_ = 0;
      start_anew();
    }
    return;
  }
  strange_ = 0;
  if (cusum_ > kChanged) {
    cusum_ = told_ = 0;
    weights_.reset();
  }
  if (direct) known_ = known_ || ++agreeing_ >= kEnoughAgree;
  for (std::size_t j = 0; j < weights_.count(); ++j) weights_.take(j, 0.5 * (misfit[j] - least));
}

void FrictionFilter::weigh_sliding(double load) noexcept {
  for (std::size_t j = 0; j < weights_.count(); ++j) {
    const double off = std::log(weights_.friction(j) / load) / (3 * TractionRatioFilter::kPlateau);
    weights_.take(j, kOneFrame * 0.5 * std::min(off * off, 25.0));
  }
}

}  // namespace slipd
