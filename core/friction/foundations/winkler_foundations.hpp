// The load history of one contact, followed for many frictions side by side (docs/theory.md §4): Popov's
// dimensionality reduction as in core/contact/history.hpp, but with a fixed number of springs, no materials,
// and one bed of springs for each friction. A spring at x touches from the normal force on at which the
// contact's radius is x; it sticks, or slips at friction times its own normal load. Lengths are in units of
// the radius that 1 N makes, so that a = cbrt(P) whatever touches what.
//
// Within 0.005 mu P of the exact history in shear_moments() for a load that the springs resolve (see follow).
// Estimate thread; fixed memory, nothing allocates or throws.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/contact/shear_moments.hpp"
#include "core/friction/foundations/winkler_kernels.hpp"

namespace slipd {

class WinklerFoundations {
 public:
  static constexpr std::size_t kMost = WinklerKernels::kBeds;

  // A bed for each friction > 0, at most kMost; no contact yet. The first constructor takes the kernels
  // given, the second those that suit this processor.
  explicit WinklerFoundations(std::span<const double> frictions, const WinklerKernels& kernels) noexcept;
  explicit WinklerFoundations(std::span<const double> frictions) noexcept;

  void clear() noexcept;  // no contact

  // The load goes straight to normal_n >= 0 and shear_n (signed); shear beyond mu P is not carried. Finite
  // numbers only. A normal force below a thousandth of the largest one since clear() is sensed by too few
  // springs to mean anything. Costs nothing where neither the load nor a bed has changed.
  void follow(double normal_n, double shear_n) noexcept;

  // Forgets the past: shear rose from nothing to shear_n under a normal force that did not change.
  void assume_monotonic(double normal_n, double shear_n) noexcept;

  // The beds for which `chosen` is true go on from the contact of bed `from`, as far as their friction holds
  // it: with the next follow(), which they have to settle in anyway. Those that have it already cost nothing.
  template <typename Chosen>
  void take_over(std::size_t from, Chosen chosen) noexcept {
    PerBed<std::int32_t> which{};
    bool any = false;
    for (std::size_t j = 0; j < count_; ++j) {
      if (copy_of_[j] != from) copy_of_[j] = kNone;
      if (j == from || !chosen(j) || copy_of_[j] == from) continue;
      copy_of_[j] = from;
      which[j] = -1;
      any = true;
    }
    if (any) take_over(from, which);
  }

  // The load that it was asked to follow last, N; 0 and 0 without a contact.
  double normal_n() const noexcept { return normal_n_; }
  double asked_n() const noexcept { return asked_n_; }
  double shear_n(std::size_t j) const noexcept { return friction_[j] * carried_n_[j]; }

  // Of bed j, 0 … frictions - 1; computed when first asked for after a change. (A spring at x counts with 2
  // x^2 and 8/3 x^4.)
  contact::ShearMoments shear_moments(std::size_t j) const noexcept;

 private:
  template <typename T>
  using PerBed = std::array<T, kMost>;
  using Rest = std::array<float, WinklerKernels::kSprings>;

  // The normal load of each spring and of all of them.
  struct Pressed {
    Rest rest{};
    float sum = 0;
    std::size_t touching = 0;  // the first springs
  };

  void reach(double radius) noexcept;
  Pressed pressed_by(double radius) const noexcept;
  void take_over(std::size_t from, const PerBed<std::int32_t>& which) noexcept;
  void settle(const PerBed<std::int32_t>& which, double far) noexcept;
  void settle_taken_over() noexcept;
  void sum_up() const noexcept;

  const WinklerKernels* kernels_;
  const std::size_t count_, vectors_;
  PerBed<double> friction_, inverse_;
  double step_ = 0;  // between springs; spring i stands at (i + 1/2) step
  double normal_n_ = 0, asked_n_ = 0;
  Pressed pressed_;
  // What beds and springs carry over the bed's friction: at most the normal force.
  PerBed<double> carried_n_{};
  std::array<PerBed<float>, WinklerKernels::kSprings> loads_{};
  PerBed<std::int32_t> taken_over_{};  // -1: with the next follow()
  // The bed that it has taken over from, as that one still is; kNone: it has a contact of its own.
  static constexpr std::size_t kNone = kMost;
  PerBed<std::size_t> copy_of_;

  struct Moments {
    PerBed<double> slip_n, legendre_n;
  };
  mutable Moments moments_{};
  mutable bool summed_ = false;
};

}  // namespace slipd
