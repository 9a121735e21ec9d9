// A pad whose taxels are tips of pillars, each on springs of its own (Winkler 1867), followed for many
// frictions side by side. An object that moves by a small way, or turns, shears all pillars alike; one that
// would carry more than friction times its own pressure slips. So what a pillar carries now depends on all
// that came before, and is known for each friction: what the pad senses tells frictions apart long before
// all pillars slip (docs/methods.md §29.5).
//
// Estimate thread; fixed memory, nothing allocates or throws.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/contact/skin_base.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Set on tasks 1 to 16 of `slipd-lab grip`, and judged on others (docs/grip.md).
struct PillarBedsOptions {
  // Standard deviation of what a pillar carries from what it should: of that and of the mean over all
  // pillars; 0.05 … 0.5. Too small: pillars of uneven stiffness pass for slip. Too large: learns slowly.
  double uneven_share = 0.25;
  // Time in which what a bed carries is drawn to what is sensed, as far as its friction holds that, to 1/e;
  // s, 0.1 … 10. What is older shows in the posterior only. Too small: slow slip comes unseen. Too large: a
  // friction that has just become so is judged by slips that it would have had before.
  double memory_s = 1;
};

class PillarBeds {
 public:
  static constexpr std::size_t kMost = 64;

  // A bed for each friction > 0, at most kMost. Throws std::invalid_argument if the layout has fewer taxels
  // than kLeastPillars, or more than kMostPillars.
  PillarBeds(const TaxelLayout& layout, std::span<const double> frictions,
             const PillarBedsOptions& options = {});

  // No contact.
  void clear() noexcept;
  // What came before is not known: the next frame's pillars are taken as they are sensed.
  void lose_history() noexcept { seen_ = false; }

  // One frame in contact, so many seconds after the one before. The taxels are those of `patch`, without any
  // that neighbours stand for.
  void follow(const ContactPatch& patch, double seconds) noexcept;

  // The squared misfit of bed j, 0 … frictions - 1, of the last frame: sum over the pillars that touch, in
  // units of its variance. Two components each.
  double misfit(std::size_t j) const noexcept { return misfit_[j]; }
  double uneven_share() const noexcept { return options_.uneven_share; }
  // Pillars that touch.
  std::size_t touching() const noexcept { return touching_; }

 private:
  struct Vector {
    double x = 0, y = 0;
  };
  using PerPillar = std::array<Vector, kMostPillars>;
  // Forces along x and y, and the torque over the pad's size, N.
  using Sums = std::array<double, 3>;
  // The shift of a bed: what a pillar at the origin gets more along x and y, and by a turn, N.
  using Shift = std::array<double, 3>;

  void sense(const ContactPatch& patch) noexcept;
  void settle(std::size_t j) noexcept;
  void slide(std::size_t j) noexcept;
  void draw_to_sensed(std::size_t j, double share) noexcept;
  double misfit_of(std::size_t j) const noexcept;
  static Vector held(const Vector& load, double limit) noexcept;
  Vector moved(std::size_t j, std::size_t i, const Shift& shift) const noexcept;

  const PillarBedsOptions options_;
  const std::size_t taxels_, count_;
  const double area_m2_;
  PerPillar place_{};  // over the pad's size
  std::array<double, kMost> friction_{};

  bool seen_ = true;
  // Of this frame, N.
  std::array<double, kMostPillars> pressed_{};
  PerPillar sheared_{};
  std::array<bool, kMostPillars> touches_{};
  std::size_t touching_ = 0;
  double sensed_n_ = 0, carried_n_ = 0;  // of the pillars that touch: P, and |Q|
  double noise_n_ = 0;                   // of a mean
  Sums goal_{};

  std::array<PerPillar, kMost> loads_{};  // of each bed, N
  std::array<double, kMost> misfit_{};
};

}  // namespace slipd
