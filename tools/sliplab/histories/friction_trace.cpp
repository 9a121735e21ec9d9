#include "tools/sliplab/histories/friction_trace.hpp"

#include "core/contact/averages.hpp"

namespace sliplab {

using slipd::contact::LoadHistory;

FrictionTrace::FrictionTrace(const slipd::TaxelLayout& layout, double center_x_m, double center_y_m)
    : layout_(layout),
      x_m_(center_x_m),
      y_m_(center_y_m),
      normal_pa_(layout.size()),
      true_pa_(layout.size()),
      former_pa_(layout.size()) {}

bool FrictionTrace::differs(const LoadHistory& contact, double shear_sigma_pa) {
  slipd::contact::taxel_averages(layout_, x_m_, y_m_, contact, normal_pa_, true_pa_);
  slipd::contact::taxel_averages(layout_, x_m_, y_m_, *former_, normal_pa_, former_pa_);
  double squares = 0;
  for (std::size_t i = 0; i < true_pa_.size(); ++i) {
    const double off =
        (static_cast<double>(true_pa_[i]) - static_cast<double>(former_pa_[i])) / shear_sigma_pa;
    squares += off * off;
  }
  return squares > kSeenSigmas * kSeenSigmas;
}

bool FrictionTrace::update(const LoadHistory& contact, double shear_sigma_pa) {
  if (!(contact.normal_n() > 0)) {
    before_.reset();
    former_.reset();
    return true;
  }
  if (!former_ && before_ && before_->friction() != contact.friction()) former_ = before_;
  if (former_) {
    former_->move_to(contact.normal_n(), contact.shear_n(), former_->friction());
    if (differs(contact, shear_sigma_pa)) former_.reset();
  }
  before_ = contact;
  return !former_;
}

}  // namespace sliplab
