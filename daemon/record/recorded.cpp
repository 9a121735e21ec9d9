#include "daemon/record/recorded.hpp"

namespace slipd {
namespace {

template <typename Enum>
std::uint8_t code_of(Enum value) noexcept {
  return static_cast<std::uint8_t>(value);
}

}  // namespace

RecordedEstimate recorded(const Estimate& estimate) noexcept {
  return {.state = code_of(estimate.state),
          .alert = code_of(estimate.alert),
          .gamma = estimate.gamma.value_or(kUnknown),
          .sigma = estimate.sigma.value_or(kUnknown),
          .friction = estimate.friction.value_or(kUnknown),
          .normal_n = estimate.normal_n.value_or(kUnknown),
          .shear_n = estimate.shear_n.value_or(kUnknown),
          .sliding = estimate.sliding ? code_of(*estimate.sliding) : RecordedEstimate::kNoCode,
          .alert_cause = code_of(estimate.alert_cause),
          .torque_nm = estimate.torque_nm.value_or(kUnknown),
          .turned_rad = estimate.turned_rad.value_or(kUnknown),
          .gamma_low = estimate.gamma_low.value_or(kUnknown),
          .friction_sigma = estimate.friction_sigma.value_or(kUnknown),
          .shear_x_n = estimate.shear_x_n.value_or(kUnknown),
          .shear_y_n = estimate.shear_y_n.value_or(kUnknown),
          .torque_sigma_nm = estimate.torque_sigma_nm.value_or(kUnknown),
          .turned_sigma_rad = estimate.turned_sigma_rad.value_or(kUnknown),
          .center_x_m = estimate.center_x_m.value_or(kUnknown),
          .center_y_m = estimate.center_y_m.value_or(kUnknown),
          .radius_m = estimate.radius_m.value_or(kUnknown),
          .a_over_r = estimate.a_over_r.value_or(kUnknown),
          .time_to_slip_s = estimate.time_to_slip_s.value_or(kUnknown),
          .grip_increase_n = estimate.grip_increase_n.value_or(kUnknown),
          .grip_increase_sigma_n = estimate.grip_increase_sigma_n.value_or(kUnknown),
          .sliding_for_s = estimate.sliding_for_s.value_or(kUnknown),
          .method = code_of(estimate.method),
          .health = code_of(estimate.health)};
}

}  // namespace slipd
