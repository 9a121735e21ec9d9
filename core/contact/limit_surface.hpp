// How much of its capacity a contact uses that carries a force Q and a torque T about its normal. An object
// in the grip slides as a rigid body about some instantaneous centre. For each rigid velocity (v, w) friction
// mu carries at most mu * integral of p |v + w x r|, whatever the pressure's shape, and the loads on the edge
// of all these bounds are the limit surface (Goyal, Ruina and Papadopoulos 1991; docs/theory.md §6.6).
//
// The pressure is given as some cells, each a square with an even pressure. Estimate thread; fixed memory,
// nothing allocates or throws.
#pragma once

#include <array>
#include <cstddef>

namespace slipd::contact {

// What a load asks of friction: mu of at least `ratio` carries it, so that Gamma = 1 - ratio/mu. A pull
// without torque has Q/P.
struct LeastFriction {
  // Dimensionless, >= 0.
  double ratio = 0;
  // Its derivatives by Q along the pull and by |T|; 1/N and 1/(N m).
  double per_shear_n = 0;
  double per_torque_nm = 0;
};

class LimitSurface {
 public:
  // Cells at most; further ones are ignored.
  static constexpr std::size_t kMost = 256;

  // No cells yet. side_m: of the squares that the cells' pressure is spread over, > 0, without what the
  // torque lacks as well: a taxel's shear is a mean, so that the torque within it is not sensed.
  void clear(double side_m) noexcept;
  // A cell at a place relative to the contact's centre, with its normal force. Noise may make some forces
  // negative; the sum must be positive.
  void add(double x_m, double y_m, double normal_n) noexcept;
  std::size_t size() const noexcept { return size_; }

  // The pull (shear_x_n, shear_y_n) through the contact's centre with the torque torque_nm about it. All zero
  // without load, without cells and where the forces do not press.
  LeastFriction least_friction(double shear_x_n, double shear_y_n, double torque_nm) const noexcept;

 private:
  std::size_t size_ = 0;
  double side_m_ = 0, normal_n_ = 0, squares_n_m2_ = 0;
  alignas(64) std::array<float, kMost> x_m_{}, y_m_{}, normal_each_n_{};
};

// That of a Hertz contact with P = 1 and a = 1: takes Q/P and T/(P a) for a contact of which only forces and
// radius are known.
LimitSurface unit_hertz_surface();

}  // namespace slipd::contact
