#include "core/margin/margin_decision.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {

void MarginDecision::propose(MeanSigma margin) noexcept {
  margin_ = margin;
  if (!(margin.sigma <= sigma_max_)) refuse(State::learning);
}

void MarginDecision::refuse(State why) noexcept {
  if (!refused_) refused_ = why;
}

void MarginDecision::widen(double sigma) noexcept {
  widened_ = norm(widened_, sigma);
}

void MarginDecision::leave_out(double share) noexcept {
  left_out_ = share;
  widen(share);
}

void MarginDecision::slide(double slip_below) noexcept {
  if (low_) low_ = 0;
  if (stands() && margin_->mean > slip_below) refuse(State::out_of_model);
}

double MarginDecision::sigma() const noexcept {
  return norm(norm(margin_->sigma, least_sigma_), widened_);
}

bool MarginDecision::stands() const noexcept {
  return margin_ && !refused_ && !failed_ && sigma() <= sigma_max_;
}

std::optional<MeanSigma> MarginDecision::margin() const noexcept {
  if (!stands()) return std::nullopt;
  return MeanSigma{margin_->mean, sigma()};
}

void MarginDecision::apply(Estimate& out) const noexcept {
  const auto now = margin();
  out.state = now ? State::ok : failed_ ? State::fault : refused_.value_or(State::learning);
  if (now) {
    out.gamma = now->mean;
    out.sigma = now->sigma;
  }
  // The pattern of a contact that slides with all of its taxels may stand still. Where the margin leaves open
  // that it slides, this is no evidence that it does not.
  if (now && now->mean <= now->sigma && out.sliding == Sliding::none) {
    out.sliding.reset();
    out.sliding_for_s.reset();
  }
  if (!low_) return;
  const double own = now ? now->mean - kOneSided95 * now->sigma : 1;
  out.gamma_low = std::clamp(std::min(own, *low_ - kOneSided95 * left_out_), 0.0, 1.0);
}

}  // namespace slipd
