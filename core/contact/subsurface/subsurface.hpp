// What taxels under a skin read of a contact on its surface. The skin is modelled as an elastic half space,
// or as a layer bonded to a rigid base at the taxels' depth (rigid_base.hpp). In a half space the stresses at
// depth d on a plane parallel to the surface are those of Boussinesq (1885) and Cerruti (1882); they do not
// depend on Poisson's ratio. In Fourier space (k: wave number) a normal traction p and a shear q_x are read
// as
//   normal:   (1 + k d) e^(-k d) p - i k_x d e^(-k d) q_x
//   shear x:  -i k_x d e^(-k d) p + (1 - d k_x^2/k) e^(-k d) q_x
//   shear y:  -i k_y d e^(-k d) p - (d k_x k_y/k) e^(-k d) q_x
// So a normal load is read as shear, too, which points outwards, and a pull as pressure, too: positive ahead
// of the contact, negative behind it.
//
// Tractions of a contact are sums of domes sqrt(1 - x^2/a^2 - y^2/b^2), for which all of this has a closed
// form (docs/theory.md §5.4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/subsurface/rigid_base.hpp"
#include "core/contact/subsurface/side_rules.hpp"
#include "core/contact/subsurface/subsurface_point.hpp"

namespace slipd::contact {

// The ellipse that a dome stands on.
struct Ellipse {
  // Half axes, m, > 0, in any order.
  double a_m = 0;
  double b_m = 0;
  // Direction of a from x to y, rad.
  double angle_rad = 0;
  bool round() const noexcept { return a_m == b_m; }
};

// What is sensed at (x, y) from the centre of a dome of unit height, `depth_m` below the surface; at depth 0
// the dome itself on the diagonal. Of a half space, along the sensor's axes. Exact to 1e-12.
SensedTensor sensed_of_dome(const Ellipse& ellipse, double depth_m, double x_m, double y_m) noexcept;

// Averages over the squares of many taxels, with derivatives. Estimate thread; allocates in its constructor.
class SubsurfaceSheet {
 public:
  // Components of LayerTensor. In a half space xn and yn are nx and ny.
  enum Component : unsigned char { nn, nx, ny, xx, xy, yy, kHalfSpace, xn = kHalfSpace, yn, kComponents };
  // Derivatives by the taxel's place from the dome's centre, by the half axes (d_a: the radius of a round
  // dome), by the log of the depth (0 without a skin) and by the angle.
  enum Of : unsigned char { value, d_u, d_v, d_a, d_depth, d_b, d_angle, kRows };

  // What is summed for each taxel. exact: as the constructor says. rough: fewer points, for the steps of a
  // fit that are not its last ones. centre: the value at its middle.
  enum class Detail : std::uint8_t { exact, rough, centre };

  // Room for so many taxels. side_m: of their squares, m. depth_m >= 0. Averages are Gauss-Legendre sums,
  // with more points at smaller depths; at depth 0 they are exact along x. They agree with the integral to
  // 1e-4 of the dome's height, at depth 0 at the rim to 5e-4 for taxels of at most a fifth of the radius.
  // bonded_poisson: see Skin::bonded_poisson; above a rigid base averages are within 5e-4, and take
  // kLayerImages times as long. Not used at depth 0.
  SubsurfaceSheet(std::size_t most_taxels, double side_m, double depth_m,
                  std::optional<double> bonded_poisson = std::nullopt);

  // Averages of a dome of unit height about the origin at taxels (u, v), along the sensor's axes. Round domes
  // under a skin are faster; their rows d_b and d_angle are not written.
  void evaluate(const Ellipse& dome, std::span<const double> u, std::span<const double> v,
                Detail detail = Detail::exact) noexcept;
  // The rows `value` alone.
  void evaluate_values(const Ellipse& dome, std::span<const double> u, std::span<const double> v,
                       Detail detail = Detail::exact) noexcept;

  // Of the last evaluation, as long as its lists.
  std::span<const double> row(Of of, Component component) const noexcept {
    const std::size_t first = of;
    if (depth_m_ > 0) {
      const bool crossed = images_.empty() && component >= kHalfSpace;
      const std::size_t which = crossed ? component - kHalfSpace + nx : component;
      return {rows_.data() + (first * components() + which) * count_, count_};
    }
    const bool sensed = component == nn || component == xx || component == yy;
    return {(sensed ? rows_ : zeros_).data() + (sensed ? first * count_ : 0), count_};
  }
  double depth_m() const noexcept { return depth_m_; }
  // Whether xn and yn are nx and ny.
  bool symmetric() const noexcept { return images_.empty(); }
  // Of the rows.
  std::size_t memory_bytes() const noexcept { return sizeof(double) * (rows_.size() + image_rows_.size()); }
  // Another depth, > 0, of a sheet under a skin. Averages keep the points of the first one.
  void set_depth(double depth_m) noexcept { depth_m_ = depth_m; }
  // Points that a taxel's average is made of, along one side.
  std::size_t points(Detail detail = Detail::exact) const noexcept { return rule_of(detail).at.size(); }

 private:
  const SideRule& rule_of(Detail detail) const noexcept { return rules_[static_cast<std::size_t>(detail)]; }
  void run(const Ellipse& dome, std::span<const double> u, std::span<const double> v, bool slopes,
           const SideRule& rule) noexcept;

  // That rows_ has under a skin.
  std::size_t components() const noexcept { return images_.empty() ? kHalfSpace : kComponents; }

  std::size_t count_ = 0;
  double side_m_, depth_m_;
  std::vector<LayerImage> images_;  // none: a half space
  std::vector<double> image_rows_;  // of one of them
  std::array<SideRule, 3> rules_;   // by Detail
  std::vector<double> integrals_;   // of the ellipse evaluated, see IntegralTable
  std::vector<double> rows_;        // at depth 0 those of nn alone, which are xx and yy as well
  std::vector<double> zeros_;       // at depth 0 the other components
};

}  // namespace slipd::contact
