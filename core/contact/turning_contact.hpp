// A Hertz contact whose load has a torque about its normal: what LoadHistory is for a pull along one line,
// for any history of P, Q along both axes and T (docs/theory.md §4.5). It begins with the tractions of a
// LoadHistory, and costs nothing before.
//
// Memory is set aside on construction; nothing allocates or throws afterwards. Not shared between threads.
#pragma once

#include <span>

#include "core/contact/hertz.hpp"
#include "core/contact/history.hpp"
#include "core/contact/limit_surface.hpp"
#include "core/contact/partial_slip.hpp"
#include "core/frame/layout.hpp"

namespace slipd::contact {

struct TurningContactOptions {
  // Radius over half the grid below which a new grid is made; 0.3 … 0.8. Too small: cells are coarse. Too
  // large: grids follow each other, and each blurs the tractions by its cells.
  double least_filled = 0.6;
};

class TurningContact {
 public:
  explicit TurningContact(const BodyPair& pair, const TurningContactOptions& options = {});

  // Whether begin() was called since the last release().
  bool active() const noexcept { return active_; }
  // The contact is lost.
  void release() noexcept;
  // The tractions of `from`, along x, from now on; `from` has a contact.
  void begin(const LoadHistory& from) noexcept;
  // The load goes there in a straight line; friction changes beforehand. normal_n > 0, friction > 0, all
  // finite. What is beyond friction slides: the load is carried in part. Only while active.
  void move_to(double normal_n, const PlaneLoad& load, double friction) noexcept;

  double contact_radius_m() const noexcept { return radius_m_; }
  // 1 - t/mu (docs/theory.md §6.6), 0 to 1.
  double safety_margin() const noexcept;
  // P in N, and the load that was asked for.
  double normal_n() const noexcept { return normal_n_; }
  const PlaneLoad& load() const noexcept { return load_; }
  double friction() const noexcept { return friction_; }

  // Pressure and shears in Pa on every taxel of `layout`, the contact's centre at (x, y). All spans have the
  // layout's size and are overwritten. Sums over a sensor that covers the contact are the load within 1 %.
  void taxel_averages(const TaxelLayout& layout, double center_x_m, double center_y_m,
                      std::span<float> normal_pa, std::span<float> shear_x_pa,
                      std::span<float> shear_y_pa) const noexcept;

 private:
  // q/(mu p), each component.
  struct Mobilised {
    double x = 0, y = 0;
  };

  void press(double normal_n) noexcept;
  void choose_grid() noexcept;
  void step_to(double normal_n, const PlaneLoad& load, double friction) noexcept;
  Mobilised utilisation(double x_m, double y_m) const noexcept;

  BodyPair pair_;
  TurningContactOptions options_;
  LimitSurface hertz_;
  PartialSlip slip_;
  bool active_ = false;
  double normal_n_ = 0, radius_m_ = 0, friction_ = 0;
  PlaneLoad load_;
  PartialSlip::Cells normal_each_n_{}, old_x_n_{}, old_y_n_{};
};

}  // namespace slipd::contact
