#include "drivers/sim/script.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace slipd::sim {
namespace {

void check(const Phase& phase, std::size_t number) {
  const auto refuse = [number](const char* what) {
    throw std::invalid_argument("cycle/" + std::to_string(number) + ": " + what);
  };
  const auto finite = [](const std::optional<Ramp>& r) {
    return !r || (std::isfinite(r->from) && std::isfinite(r->to));
  };
  if (phase.duration_ns <= 0) refuse("a phase must last longer than nothing");
  if (!finite(phase.normal_n) || !finite(phase.shear_n) || !finite(phase.load) || !finite(phase.torque_nm))
    refuse("forces and torques must be finite");
  if (phase.normal_n && (phase.normal_n->from < 0 || phase.normal_n->to < 0))
    refuse("a normal force cannot be negative");
  if (phase.shear_n && phase.load) refuse("give shear_n or load, not both");
  if (phase.friction && !(std::isfinite(*phase.friction) && *phase.friction > 0))
    refuse("friction must be positive");
}

// The tangential force with which a phase without shear continues: the one that friction could hold.
LoadTarget held(const LoadTarget& last) noexcept {
  const double most = last.friction * last.normal_n;
  return {last.normal_n, std::clamp(last.shear_n(last.normal_n), -most, most), false, last.friction,
          last.torque_nm};
}

}  // namespace

Script::Script(const std::vector<Phase>& cycle) {
  if (cycle.empty()) throw std::invalid_argument("cycle: needs at least one phase");
  LoadTarget last;
  // Twice, because the first phase begins with the load that the last one left.
  for (int round = 0; round < 2; ++round) {
    phases_.clear();
    end_ns_.clear();
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const Phase& phase = cycle[i];
      check(phase, i);
      LoadTarget begin = held(last);
      begin.friction = phase.friction.value_or(last.friction);
      begin.by_load = phase.load.has_value();
      LoadTarget end = begin;
      if (phase.normal_n) {
        begin.normal_n = phase.normal_n->from;
        end.normal_n = phase.normal_n->to;
      }
      if (const auto& shear = phase.load ? phase.load : phase.shear_n) {
        begin.shear = shear->from;
        end.shear = shear->to;
      }
      if (phase.torque_nm) {
        begin.torque_nm = phase.torque_nm->from;
        end.torque_nm = phase.torque_nm->to;
      }
      phases_.push_back({begin, end});
      end_ns_.push_back(phase.duration_ns + (end_ns_.empty() ? 0 : end_ns_.back()));
      last = end;
    }
  }
}

std::size_t Script::phase_at(std::int64_t in_cycle_ns) const noexcept {
  const auto found = std::upper_bound(end_ns_.begin(), end_ns_.end(), in_cycle_ns);
  return static_cast<std::size_t>(found - end_ns_.begin());
}

double Script::share(std::size_t phase, std::int64_t in_cycle_ns) const noexcept {
  const std::int64_t begin_ns = phase == 0 ? 0 : end_ns_[phase - 1];
  return static_cast<double>(in_cycle_ns - begin_ns) / static_cast<double>(end_ns_[phase] - begin_ns);
}

LoadTarget Script::at(std::size_t phase, double share) const noexcept {
  const auto& [begin, end] = phases_[phase];
  LoadTarget target = begin;
  target.normal_n += share * (end.normal_n - begin.normal_n);
  target.shear += share * (end.shear - begin.shear);
  target.torque_nm += share * (end.torque_nm - begin.torque_nm);
  return target;
}

}  // namespace slipd::sim
