// A contact under any history of normal and tangential load: P and Q may rise, fall
// and reverse.
//
// The traction of such a contact is a signed sum of disc terms D_x (docs/theory.md §4.1). Sums of discs are
// one-dimensional (method of dimensionality reduction, §4.2): write w = x^2; the normal load is the line n(w)
// = a^2 - w, the shear some t(w) between -mu n and +mu n, and each w is a spring of its own that sticks
// (moves by what all stuck springs move) or slips (lies on a limit). t is piecewise linear in w, so a state
// is a short list of knots, exact for straight load paths; a knot where the slope jumps by c is a disc term
// of coefficient c. Passed extremes are wiped by the limits themselves: no bookkeeping of turning points is
// needed.
//
// Memory is set aside on construction; nothing allocates afterwards. Not shared between threads.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/hertz.hpp"

namespace slipd::contact {

// coefficient * D_radius.
struct DiscTerm {
  double radius_m = 0;
  double coefficient = 0;
};

class LoadHistory {
 public:
  // No contact yet. `capacity`: knots kept at most; beyond it those that matter least are merged.
  explicit LoadHistory(const BodyPair& pair, std::size_t capacity = 256);

  // The load goes in a straight line in the (P, Q) plane to normal_n and shear_n (signed, along one
  // direction) while friction, changed beforehand, stays. A shear beyond mu P slides: it is carried only as
  // far as friction holds. Throws ContactError for a force or friction without meaning, and leaves the state
  // as it was.
  void move_to(double normal_n, double shear_n, double friction);

  double normal_n() const noexcept { return normal_n_; }
  double shear_n() const noexcept { return shear_n_; }  // carried, signed
  double friction() const noexcept { return friction_; }
  double contact_radius_m() const noexcept;
  double safety_margin() const noexcept;  // 1 - |Q|/(mu P); NaN without contact
  const BodyPair& pair() const noexcept { return pair_; }

  // The shear traction's terms, largest radius first; the pressure is the one term {contact_radius_m(), 1}.
  // Valid until the next move_to. Empty without load.
  std::span<const DiscTerm> shear_terms() const noexcept { return terms_; }

  // Pointwise p and signed q in Pa at r >= 0.
  double pressure_pa(double r_m) const noexcept;
  double shear_pa(double r_m) const noexcept;

 private:
  struct Knot {
    double w = 0;  // m^2
    double t = 0;  // m^2, shear in the unit of n
  };
  using Curve = std::vector<Knot>;

  void straight(double normal_n, double shear_n, int depth);
  void carry_over(double old_edge, double edge);
  void slip_to(double target_n, double most_n, double edge);
  bool steeper_than_friction(double edge_w) const noexcept;
  void limit(double shift, double edge_w, double friction, Curve& out) const;
  double force_n(const Curve& curve) const;
  void simplify();
  void refresh_terms();

  BodyPair pair_;
  std::size_t capacity_;
  double normal_n_ = 0, shear_n_ = 0, friction_ = 1;
  Curve knots_, base_, trial_;
  std::vector<DiscTerm> terms_;
};

}  // namespace slipd::contact
