// The load that the simulated gripper applies: a cycle of phases, repeated without end, as a pure function of
// time.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace slipd::sim {

// A value that changes linearly from the phase's begin to its end. N, or for a load a fraction of mu P.
struct Ramp {
  double from = 0;  // at the phase's begin
  double to = 0;    // at the phase's end
};

// An absent value stays as the phase before left it. At most one of shear_n and load is present.
struct Phase {
  std::int64_t duration_ns = 0;    // > 0
  std::optional<Ramp> normal_n;    // normal force, N, >= 0
  std::optional<Ramp> shear_n;     // tangential force along x, N, signed; beyond mu P the contact slides
  std::optional<Ramp> load;        // the same as a fraction of mu P, signed; beyond 1 the contact slides
  std::optional<double> friction;  // coefficient of friction from the phase's begin on, > 0
  // Torque about the contact's normal, N m, positive from x to y.
  std::optional<Ramp> torque_nm = std::nullopt;
};

// The load that the script prescribes at one moment.
struct LoadTarget {
  double normal_n = 0;    // normal force, N
  double shear = 0;       // tangential force, N; with by_load a fraction of mu P
  bool by_load = false;   // the unit of `shear`
  double friction = 0.5;  // coefficient of friction
  double torque_nm = 0;   // about the contact's normal, N m

  // The tangential force in N at the normal force `actual_normal_n`, which a controller can set.
  double shear_n(double actual_normal_n) const noexcept {
    return by_load ? shear * friction * actual_normal_n : shear;
  }
};

class Script {
 public:
  // Throws std::invalid_argument, which names the phase from 0, for no phases, a duration that is not
  // positive, forces or torques that are not finite or negative normal forces, friction that is not positive,
  // or shear_n and load together.
  explicit Script(const std::vector<Phase>& cycle);

  std::int64_t cycle_ns() const noexcept { return end_ns_.back(); }

  // Calls visit(LoadTarget) for each corner after from_ns up to to_ns, with both its left and its right
  // limit, and for to_ns itself; between the calls the load is linear. from_ns <= to_ns, counted from the
  // start. Of more than one whole cycle only the last is visited.
  template <class Visit>
  void walk(std::int64_t from_ns, std::int64_t to_ns, Visit visit) const {
    if (to_ns - from_ns > cycle_ns()) from_ns = to_ns - cycle_ns();
    std::size_t phase = phase_at(from_ns % cycle_ns());
    std::int64_t begin_of_cycle = from_ns - from_ns % cycle_ns();
    while (begin_of_cycle + end_ns_[phase] <= to_ns) {
      visit(at(phase, 1));
      if (++phase == phases_.size()) {
        phase = 0;
        begin_of_cycle += cycle_ns();
      }
      visit(at(phase, 0));
    }
    visit(at(phase, share(phase, to_ns - begin_of_cycle)));
  }

 private:
  struct Piece {
    LoadTarget begin, end;  // equal in by_load and friction
  };
  std::size_t phase_at(std::int64_t in_cycle_ns) const noexcept;
  double share(std::size_t phase, std::int64_t in_cycle_ns) const noexcept;
  LoadTarget at(std::size_t phase, double share) const noexcept;

  std::vector<Piece> phases_;
  std::vector<std::int64_t> end_ns_;  // of each phase, in the cycle
};

}  // namespace slipd::sim
