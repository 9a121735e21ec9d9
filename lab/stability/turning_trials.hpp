// Trials of the estimator chain with contacts under force and torque at their extremes: torque near 0, force
// near 0, both near 0, friction near 0, the begin of slip, and layouts that do not measure a torque.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "lab/stability/trials.hpp"

namespace lab {

enum class TurningAxis : std::uint8_t {
  mixture,   // atan2 of torque over its most by force over its most, degrees: 0 a pull, 90 a torque alone
  load,      // force and torque together, share of what friction holds
  friction,  // mu
  one_row,   // taxels in one line, as many as a side has; mixture
  one_taxel  // a force vector; mixture
};
inline constexpr TurningAxis kTurningAxes[] = {TurningAxis::mixture, TurningAxis::load, TurningAxis::friction,
                                               TurningAxis::one_row, TurningAxis::one_taxel};

std::string_view name_of(TurningAxis axis) noexcept;  // as in tables: "mixture", …
std::vector<double> places_on(TurningAxis axis);

// Mixture and share of the load are drawn where the axis does not set them. Contacts on a row of taxels and
// on one taxel are followed over time with known friction; the others are single frames.
std::vector<RobustnessRow> measure_turning(const TrialSetup& setup, const Done& done);

}  // namespace lab
