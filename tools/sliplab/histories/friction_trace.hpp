// Whether a change of friction shows in the frames. Friction that changes under a contact that sticks, or
// that is held still, leaves the tractions as they were: no sensor can observe it, and no sigma can be blamed
// for it.
#pragma once

#include <optional>
#include <vector>

#include "core/contact/history.hpp"
#include "core/frame/layout.hpp"

namespace sliplab {

class FrictionTrace {
 public:
  // A frame shows the change if its shear differs from that of the former friction by so many standard
  // deviations of the noise, taken over all taxels: root of the sum of squares. Less: changes that noise
  // hides count as seen.
  static constexpr double kSeenSigmas = 5;

  // The contact's centre, m. `layout` must outlive this object.
  FrictionTrace(const slipd::TaxelLayout& layout, double center_x_m, double center_y_m);

  // After each frame, in order. `contact`: the true one at this frame. `shear_sigma_pa`: standard deviation
  // of one taxel, > 0. False while friction has changed and no frame has shown it yet.
  bool update(const slipd::contact::LoadHistory& contact, double shear_sigma_pa);

 private:
  bool differs(const slipd::contact::LoadHistory& contact, double shear_sigma_pa);

  const slipd::TaxelLayout& layout_;
  double x_m_, y_m_;
  std::optional<slipd::contact::LoadHistory> before_;  // the true contact, a frame ago
  std::optional<slipd::contact::LoadHistory> former_;  // what it would be had friction not changed
  std::vector<float> normal_pa_, true_pa_, former_pa_;
};

}  // namespace sliplab
