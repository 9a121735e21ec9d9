// A rough, heavy object on independent elastic elements: pillars, or small pieces of a skin. Each element is
// a spring of its own height and friction (Winkler's foundation; Johnson, Contact Mechanics, 1985, 4.3). It
// carries shear up to Coulomb's limit and slips by itself beyond it. When all slip, the object slides as a
// body with a mass, and its relief moves over the elements.
//
// Motion is along x. Allocates on construction only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/sim/effects/texture.hpp"

namespace slipd::sim {

struct RoughContactSettings {
  // Of the elements' rubber: Young's modulus, Pa, and thickness, m. A deeper layer is softer.
  double modulus_pa = 1e6;
  double thickness_m = 0.004;
  // Tangential over normal stiffness, no unit; 1/3 for a long rubber pillar … 1.
  double tangential = 0.5;
  // Standard deviation of the elements' heights, m.
  double height_sigma_m = 0;
  // Relief of the object.
  TextureSettings texture;
  // Curvature of object and sensor together, 1/R1 + 1/R2, 1/m; 0: flat on flat.
  double curvature_per_m = 0;
  // Where its apex is, m.
  double apex_x_m = 0, apex_y_m = 0;
  // Friction of the elements with y above 0 over that of the others, no unit; 1: all alike.
  double one_side_friction = 1;
  // What slides, kg; above 0.
  double mass_kg = 0.2;
};

class RoughContact {
 public:
  // Elements at (x_m, y_m), each of area_m2.
  RoughContact(const RoughContactSettings& settings, std::span<const double> x_m, std::span<const double> y_m,
               double area_m2, std::uint64_t seed);

  // Presses with normal_n >= 0, N; friction > 0. Without force the contact ends; the next one begins
  // elsewhere on the object.
  void press(double normal_n, double friction) noexcept;
  // What friction can hold of this pressing, N.
  double capacity_n() const noexcept { return capacity_n_; }
  // Pulls with shear_n, N, signed, for dt_s. Beyond the capacity the object slides, and goes on until
  // friction has stopped it.
  void pull(double shear_n, double dt_s) noexcept;

  // Of each element, N: pressing >= 0, and along x.
  std::span<const double> normal_n() const noexcept { return normal_n_; }
  std::span<const double> shear_n() const noexcept { return shear_n_; }
  // Sum over the elements, N.
  double carried_n() const noexcept { return carried_n_; }
  // 1 - |Q|/capacity; 0 while it slides, NaN without contact.
  double safety_margin() const noexcept;
  // capacity / P; NaN without contact.
  double friction() const noexcept;
  bool sliding() const noexcept { return speed_m_s_ != 0; }
  // How far the object has slid since the contact began, m, signed.
  double slid_m() const noexcept { return slid_m_; }

 private:
  void begin_anew() noexcept;
  void place_object() noexcept;
  double force_at(double approach_m) const noexcept;
  double shear_at(double shift_m) const noexcept;
  double element_shear(std::size_t i, double shift_m) const noexcept;
  void stick(double shear_n) noexcept;
  void slide(double shear_n, double dt_s) noexcept;

  RoughContactSettings settings_;
  Texture texture_;
  std::vector<double> x_m_, y_m_, height_m_, side_;  // side_: friction of the element over the nominal one
  double stiffness_n_m_;                             // of one element
  std::vector<double> gap_m_;                        // to the object's lowest point, of each element
  std::vector<double> anchor_m_;                     // shift of the object at which the element has no shear
  std::vector<double> normal_n_, shear_n_, limit_n_;
  double pressed_n_ = 0, capacity_n_ = 0, carried_n_ = 0;
  double shift_m_ = 0, slid_m_ = 0, speed_m_s_ = 0;
  std::uint64_t contacts_ = 0;  // since the start
};

}  // namespace slipd::sim
