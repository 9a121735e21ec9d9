// What taxels read of a contact with an object that is no sphere, or under a skin. Pressure and shear of any
// shape are the same signed sums as a sphere's, with the shape's own pressure at the force of each term
// (Ciavarella 1998a, 1998b; Jäger 1998; docs/theory.md §4.1, §4.6). So a LoadHistory and its margin hold for
// it as well. Set-up and device threads; allocates in its constructor only.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/history.hpp"
#include "core/contact/subsurface/subsurface.hpp"
#include "core/frame/layout.hpp"

namespace slipd::contact {

struct ContactGeometry {
  // Depth of the taxels under the surface, m, >= 0.
  double depth_m = 0;
  // See Skin::bonded_poisson. Not used at depth 0.
  std::optional<double> bonded_poisson = std::nullopt;
  // Long over short axis of the contact, >= 1; its area and force are those of the round one.
  double stretch = 1;
  // Direction of the long axis from x to y, rad.
  double angle_rad = 0;
  // n of a gap that grows as r^n, 2 … 8: 2 is a sphere, 8 is nearly flat. At 1 N the contact is as large as
  // Hertz's.
  double power = 2;
  // The contact model of averages.hpp.
  bool plain() const noexcept { return depth_m == 0 && stretch == 1 && power == 2; }
  bool operator==(const ContactGeometry&) const = default;
};

class ContactField {
 public:
  ContactField(const TaxelLayout& layout, const ContactGeometry& geometry);

  // Another direction of the long axis, rad.
  void turn(double angle_rad) noexcept { geometry_.angle_rad = angle_rad; }

  // Averages over the taxels in Pa, the contact's centre at (x, y), its pull in the direction `pull_rad` from
  // x to y. All spans have the layout's size and are overwritten.
  void sense(const LoadHistory& contact, double x_m, double y_m, double pull_rad, std::span<float> normal_pa,
             std::span<float> shear_x_pa, std::span<float> shear_y_pa) noexcept;

 private:
  // The tractions of a disc term, each over the term's force_n.
  struct Force {
    double normal = 0, shear_x = 0, shear_y = 0;  // over force_n
  };
  void add_term(double force_n, double round_radius_m, const Force& force) noexcept;
  void add_dome(double radius_m, double height_pa, const Force& force) noexcept;

  ContactGeometry geometry_;
  SubsurfaceSheet sheet_;
  std::vector<double> x_m_, y_m_, u_, v_;
  std::vector<double> normal_, shear_x_, shear_y_;
};

}  // namespace slipd::contact
