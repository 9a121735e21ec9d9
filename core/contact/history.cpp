#include "core/contact/history.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

namespace slipd::contact {
namespace {

// A straight path that unloads a curve which is steeper somewhere than friction (a greater one left it so)
// may touch both limits, and is followed in 2^kDepth parts, or fewer of which each leaves kPart of the
// contact; every other one in a single step, which is exact: both limits fall by the same for all w, and what
// is nowhere steeper than they are meets one of them only.
constexpr int kDepth = 6;
constexpr double kPart = 0.98;

// Of the whole: by how much the curve may be steeper for rounding's sake.
constexpr double kSteeper = 1e-9;

// Of the whole: what two slopes may differ by and still be one line.
constexpr double kCollinear = 1e-13;

}  // namespace

LoadHistory::LoadHistory(const BodyPair& pair, std::size_t capacity)
    : pair_(pair), capacity_(std::max<std::size_t>(capacity, 8)) {
  // Cutting a curve at its limits adds at most two knots to each of its pieces.
  const std::size_t most = 3 * capacity_ + 8;
  knots_.reserve(most);
  base_.reserve(most);
  trial_.reserve(most);
  terms_.reserve(most);
}

double LoadHistory::contact_radius_m() const noexcept {
  return pair_.contact_radius_m(normal_n_);
}

double LoadHistory::safety_margin() const noexcept {
  if (normal_n_ == 0) return std::numeric_limits<double>::quiet_NaN();
  return std::max(0.0, 1 - std::fabs(shear_n_) / (friction_ * normal_n_));
}

void LoadHistory::move_to(double normal_n, double shear_n, double friction) {
  check_normal_force(normal_n);
  check_friction(friction);
  if (!std::isfinite(shear_n)) throw ContactError("Q: a tangential force must be finite");
  const bool weaker = friction < friction_;
  friction_ = friction;
  if (weaker && normal_n_ > 0) straight(normal_n_, shear_n_, 0);
  straight(normal_n, shear_n, kDepth);
  refresh_terms();
}

// What the contact carried so far, over the extent that it has now: a rim that leaves the contact takes its
// traction with it, a rim that is new carries none yet.
void LoadHistory::carry_over(double old_edge, double edge) {
  base_ = knots_;
  if (base_.empty()) base_.push_back({0, 0});
  if (edge < old_edge) {  // the rim leaves the contact and what it carried is lost
    while (base_[base_.size() - 2].w >= edge) base_.pop_back();  // the first is at 0
    Knot& last = base_.back();
    const Knot& before = base_[base_.size() - 2];
    last.t = before.t + (last.t - before.t) * (edge - before.w) / (last.w - before.w);
    last.w = edge;
  } else if (edge > old_edge) {
    base_.push_back({edge, 0});
  }
}

// Springs stick and move by one shift, as far as friction lets them; the shift is the one that carries
// `target_n` in all (docs/theory.md §4.3). Bracketed by the shifts at which everything slips, and solved by
// TOMS 748.
void LoadHistory::slip_to(double target_n, double most_n, double edge) {
  double low = 0, high = 0;
  for (const auto& knot : base_) {
    low = std::min(low, -friction_ * edge - knot.t);
    high = std::max(high, friction_ * edge - knot.t);
  }
  const auto excess = [&](double shift) {
    limit(shift, edge, friction_, trial_);
    return force_n(trial_) - target_n;
  };
  std::uintmax_t most_steps = 100;
  const auto bracket = boost::math::tools::toms748_solve(
      excess, low, high, -most_n - target_n, most_n - target_n,
      [](double l, double h) { return h - l <= 2e-16 * std::max(std::fabs(l), std::fabs(h)); }, most_steps);
  limit(0.5 * (bracket.first + bracket.second), edge, friction_, trial_);
}

// One straight piece of path with friction as it is (docs/theory.md §4.3).
void LoadHistory::straight(double normal_n, double shear_n, int depth) {
  const double radius = pair_.contact_radius_m(normal_n);
  const double edge = radius * radius;
  if (edge == 0) {  // no force, or none that a contact's extent could be computed of
    knots_.clear();
    normal_n_ = shear_n_ = 0;
    return;
  }
  // cppcheck-suppress containerOutOfBounds ; who carries a load has a knot at its edge
  const double old_edge = normal_n_ > 0 ? knots_.back().w : 0;
  const double most_n = friction_ * normal_n;
  const double target = std::clamp(shear_n, -most_n, most_n);
  const double d_normal = normal_n - normal_n_;
  const double d_shear = target - shear_n_;

  if (edge < kPart * old_edge && std::fabs(target) < most_n && depth > 0 && steeper_than_friction(edge)) {
    const double half_n = 0.5 * (normal_n_ + normal_n), half_q = 0.5 * (shear_n_ + target);
    straight(half_n, half_q, depth - 1);
    straight(normal_n, shear_n, depth - 1);
    return;
  }

  carry_over(old_edge, edge);
  if (std::fabs(target) >= most_n) {
    const double sign = target < 0 ? -1 : 1;
    trial_.assign({{0, sign * friction_ * edge}, {edge, 0}});
  } else if (d_normal > 0 && std::fabs(d_shear) <= friction_ * d_normal) {
    // All sticks: what is there moves on, the new ring takes its share of the increment.
    const double moved = d_shear / d_normal * (edge - old_edge);
    trial_ = base_;
    for (auto& knot : trial_) {
      if (knot.w < edge) knot.t += moved;
    }
  } else {
    slip_to(target, most_n, edge);
  }
  knots_.swap(trial_);
  normal_n_ = normal_n;
  shear_n_ = target;
  simplify();
}

// Within what will be left of the contact.
bool LoadHistory::steeper_than_friction(double edge) const noexcept {
  for (std::size_t i = 0; i + 1 < knots_.size() && knots_[i].w < edge; ++i) {
    const double rise = std::fabs(knots_[i + 1].t - knots_[i].t);
    if (rise > friction_ * (knots_[i + 1].w - knots_[i].w + kSteeper * edge)) return true;
  }
  return false;
}

// base_ shifted as a rigid whole, then cut to what friction holds: |t| <= friction * (edge - w).
void LoadHistory::limit(double shift, double edge, double friction, Curve& out) const {
  const auto clamped = [&](double w, double t) {
    const double most = friction * std::max(0.0, edge - w);
    return Knot{w, std::clamp(t, -most, most)};
  };
  out.clear();
  for (std::size_t i = 0;; ++i) {
    const Knot here{base_[i].w, base_[i].t + shift};
    out.push_back(clamped(here.w, here.t));
    if (i + 1 == base_.size()) break;
    const Knot next{base_[i + 1].w, base_[i + 1].t + shift};
    double cuts[2];
    int count = 0;
    for (const double sign : {1.0, -1.0}) {
      const double d0 = here.t - sign * friction * (edge - here.w);
      const double d1 = next.t - sign * friction * (edge - next.w);
      if (d0 * d1 < 0) cuts[count++] = here.w + (next.w - here.w) * (d0 / (d0 - d1));
    }
    if (count == 2 && cuts[0] > cuts[1]) std::swap(cuts[0], cuts[1]);
    for (int c = 0; c < count; ++c) {
      out.push_back(clamped(cuts[c], here.t + (next.t - here.t) * (cuts[c] - here.w) / (next.w - here.w)));
    }
  }
}

// (2 E*/R) times the integral of t(x^2) over x, piece by piece in a form without cancellation (docs/theory.md
// §4.2).
double LoadHistory::force_n(const Curve& curve) const {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const double x0 = std::sqrt(curve[i].w), x1 = std::sqrt(curve[i + 1].w);
    if (x1 <= x0) continue;
    const double rise = (curve[i + 1].t - curve[i].t) * (x1 + 2 * x0) / (3 * (x1 + x0));
    sum += (x1 - x0) * (curve[i].t + rise);
  }
  return 2 * pair_.modulus_pa / pair_.radius_m * sum;
}

void LoadHistory::simplify() {
  const double edge = knots_.back().w;
  for (double tolerance = kCollinear;; tolerance *= 8) {
    std::size_t kept = 1;
    for (std::size_t i = 1; i + 1 < knots_.size(); ++i) {
      const Knot& before = knots_[kept - 1];
      const Knot& after = knots_[i + 1];
      const double line = before.t + (after.t - before.t) * (knots_[i].w - before.w) / (after.w - before.w);
      const bool same_place = after.w - knots_[i].w <= 1e-15 * edge || knots_[i].w - before.w <= 1e-15 * edge;
      if (!same_place && std::fabs(knots_[i].t - line) > tolerance * friction_ * edge)
        knots_[kept++] = knots_[i];
    }
    knots_[kept++] = knots_.back();
    knots_.resize(kept);
    if (knots_.size() <= capacity_) return;
  }
}

void LoadHistory::refresh_terms() {
  terms_.clear();
  double slope_outside = 0;
  for (std::size_t i = knots_.size(); i-- > 1;) {
    const double slope = (knots_[i].t - knots_[i - 1].t) / (knots_[i].w - knots_[i - 1].w);
    const double coefficient = slope_outside - slope;
    if (coefficient != 0) terms_.push_back({std::sqrt(knots_[i].w), coefficient});
    slope_outside = slope;
  }
}

double LoadHistory::pressure_pa(double r_m) const noexcept {
  const double a = contact_radius_m();
  return r_m < a ? pair_.disc_scale_pa_per_m() * std::sqrt((a - r_m) * (a + r_m)) : 0;
}

double LoadHistory::shear_pa(double r_m) const noexcept {
  double sum = 0;
  for (const auto& term : terms_) {
    if (r_m < term.radius_m)
      sum += term.coefficient * std::sqrt((term.radius_m - r_m) * (term.radius_m + r_m));
  }
  return pair_.disc_scale_pa_per_m() * sum;
}

}  // namespace slipd::contact
