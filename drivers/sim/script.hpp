// What the simulated gripper does: a cycle of phases, repeated for ever, as a pure function of time.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace slipd::sim {

// From the phase's begin to its end in a straight line. N, or for a load a fraction of mu P.
struct Ramp {
  double from = 0;
  double to = 0;
};

// What is absent stays as the phase before left it. Of shear_n and load at most one is there.
struct Phase {
  std::int64_t duration_ns = 0;
  std::optional<Ramp> normal_n;    // >= 0
  std::optional<Ramp> shear_n;     // signed, along x; beyond mu P the contact slides
  std::optional<Ramp> load;        // the same as a fraction of mu P, 1 and more: gross slip
  std::optional<double> friction;  // from the phase's begin on, > 0
};

// What is asked of the contact at one moment.
struct Demand {
  double normal_n = 0;
  double shear = 0;  // N, or the fraction if by_load
  bool by_load = false;
  double friction = 0.5;

  // The tangential force asked for when the normal force is `actual_normal_n` (a controller may grip as it
  // likes).
  double shear_n(double actual_normal_n) const noexcept {
    return by_load ? shear * friction * actual_normal_n : shear;
  }
};

class Script {
 public:
  // Throws std::invalid_argument, naming the phase from 0, for no phases, a duration that is not positive,
  // forces or friction without meaning, or shear_n and load together.
  explicit Script(const std::vector<Phase>& cycle);

  std::int64_t cycle_ns() const noexcept { return end_ns_.back(); }

  // Calls visit(Demand) for each corner after from_ns up to to_ns, both sides of it where something jumps,
  // and for to_ns itself: the straight pieces of what happens in between. from_ns <= to_ns, counted from the
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
    Demand begin, end;  // alike in by_load and friction
  };
  std::size_t phase_at(std::int64_t in_cycle_ns) const noexcept;
  double share(std::size_t phase, std::int64_t in_cycle_ns) const noexcept;
  Demand at(std::size_t phase, double share) const noexcept;

  std::vector<Piece> phases_;
  std::vector<std::int64_t> end_ns_;  // of each phase, in the cycle
};

}  // namespace slipd::sim
