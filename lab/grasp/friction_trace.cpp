#include "lab/grasp/friction_trace.hpp"

#include <cmath>

#include "core/contact/averages.hpp"

namespace lab {

FrictionTrace::FrictionTrace(const slipd::TaxelLayout& layout, double center_x_m, double center_y_m)
    : layout_(layout),
      x_m_(center_x_m),
      y_m_(center_y_m),
      normal_pa_(layout.size()),
      true_pa_(layout.size()),
      other_pa_(layout.size()) {}

bool FrictionTrace::differs(const LoadHistory& contact, double shear_sigma_pa) {
  slipd::contact::taxel_averages(layout_, x_m_, y_m_, contact, normal_pa_, true_pa_);
  slipd::contact::taxel_averages(layout_, x_m_, y_m_, *other_, normal_pa_, other_pa_);
  double squares = 0;
  for (std::size_t i = 0; i < true_pa_.size(); ++i) {
    const double off =
        (static_cast<double>(true_pa_[i]) - static_cast<double>(other_pa_[i])) / shear_sigma_pa;
    squares += off * off;
  }
  return squares > kSeenSigmas * kSeenSigmas;
}

// The frames since the change, had it been to `friction`.
void FrictionTrace::replay(double friction) {
  other_ = at_change_;
  for (const auto& [normal_n, shear_n] : loads_) other_->move_to(normal_n, shear_n, friction);
}

bool FrictionTrace::update(const LoadHistory& contact, double shear_sigma_pa) {
  if (!(contact.normal_n() > 0)) {
    before_.reset();
    other_.reset();
    return true;
  }
  const bool changed = before_ && before_->friction() != contact.friction();
  if (changed && !other_) {
    other_ = at_change_ = before_;
    loads_.clear();
  }
  before_ = contact;
  if (!other_) return true;
  loads_.emplace_back(contact.normal_n(), contact.shear_n());
  other_->move_to(contact.normal_n(), contact.shear_n(), other_->friction());
  // From the former friction on, by half the way to the true one, to the first that the frame does not tell
  // from it.
  while (differs(contact, shear_sigma_pa)) {
    const double higher = std::log(contact.friction() / other_->friction());
    if (higher < kToldApart) {  // or it fell: then the contact has slipped, and shows it
      other_.reset();
      return true;
    }
    replay(other_->friction() * std::exp(0.5 * higher));
  }
  return false;
}

}  // namespace lab
