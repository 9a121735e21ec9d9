// Functions of the distance from the centre of a round contact under a skin, of which all that taxels read of
// it is made (docs/methods.md §23.7), tabulated with their slopes. Estimate thread; nothing allocates after
// construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/contact/subsurface/subsurface.hpp"

namespace slipd {

// A trial contact; as ContactShape's unknowns.
struct RoundTrial {
  // Its centre and radius, m.
  double x_m = 0, y_m = 0, radius_m = 0;
  // Peak pressure, Pa; Q/P; Gamma in (0, 1); direction of Q from x to y, rad.
  double peak_pa = 0, load = 0, gamma = 0, direction_rad = 0;
};

class RadialFieldTable {
 public:
  using Detail = contact::SubsurfaceSheet::Detail;

  // Functions of the distance r from the centre. O: of the contact's dome; M: of it less k times the stick
  // zone's, which slides; size: derivative by the log of the radius; K: of M by k. nn, rn, nr, rr and tt are
  // the components along the normal, the radius and across it: rn the shear along the radius of a normal
  // traction, nr the pressure of a traction along the radius.
  enum Function : std::uint8_t {
    o_nn,
    o_rn,
    m_nr,
    m_rr,
    m_tt,
    sloped,  // functions whose derivatives by r are needed
    size_o_nn = sloped,
    size_o_rn,
    size_m_nr,
    size_m_rr,
    size_m_tt,
    k_nr,
    k_rr,
    k_tt,
    used
  };
  // Values of the functions at a node, and as many slopes, over one step.
  static constexpr std::size_t kFunctions = 16, kPerNode = 2 * kFunctions;
  // kGhosts: nodes behind the last one in use, which slopes need.
  static constexpr std::size_t kMostNodes = 160, kGhosts = 2;

  // depth_m > 0, else never used. bonded_poisson: see Skin.
  RadialFieldTable(double depth_m, std::optional<double> bonded_poisson);

  void set_depth(double depth_m) noexcept { sheet_.set_depth(depth_m); }

  // Distance of nodes, m. Cubics between them are within 1e-5 of the height, and 5e-4 with `rough`.
  double step_m(Detail detail) const noexcept;
  // Points that a node's mean over a square is made of.
  static std::size_t points(Detail detail) noexcept;

  // Means over squares whose sides have all directions alike, exact to the fourth power of the side, and to
  // the second with `rough`. nodes: at most kMostNodes, ghosts included.
  void fill(const RoundTrial& trial, Detail detail, std::size_t nodes, double square_m) noexcept;
  const double* data() const noexcept { return table_.data(); }

  std::size_t memory_bytes() const noexcept;

 private:
  contact::SubsurfaceSheet sheet_;
  std::vector<double> u_, v_, functions_, table_;
};

}  // namespace slipd
