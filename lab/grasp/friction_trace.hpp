// Whether a change of friction shows in the frames. Friction that changes under a contact that sticks, or
// that is held still, leaves the tractions as they were: no sensor can observe it, and no sigma can be blamed
// for it. Friction that has risen shows its value only where something slips anew.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/contact/history.hpp"
#include "core/frame/layout.hpp"

namespace lab {

class FrictionTrace {
 public:
  // A frame tells two frictions apart if its shear under the one differs from that under the other by so many
  // standard deviations of the noise, over all taxels: root of the sum of squares. Less: changes that noise
  // hides count as seen.
  static constexpr double kSeenSigmas = 5;
  // A friction that has risen has a trace if a frame tells it from one so much lower; log mu. Less: rises
  // count as unseen for longer.
  static constexpr double kToldApart = 0.05;

  // The contact's centre, m. `layout` must outlive this object.
  FrictionTrace(const slipd::TaxelLayout& layout, double center_x_m, double center_y_m);

  // After each frame, in order. `contact`: the true one at this frame. `shear_sigma_pa`: standard deviation
  // of one taxel, > 0. False while friction has changed and the frames since then would be the same with the
  // former friction, or, if it has risen, with a lower one.
  bool update(const slipd::contact::LoadHistory& contact, double shear_sigma_pa);

 private:
  using LoadHistory = slipd::contact::LoadHistory;

  bool differs(const LoadHistory& contact, double shear_sigma_pa);
  void replay(double friction);

  const slipd::TaxelLayout& layout_;
  double x_m_, y_m_;
  std::optional<LoadHistory> before_;             // the true contact, a frame ago
  std::optional<LoadHistory> at_change_;          // the same when friction changed
  std::vector<std::pair<double, double>> loads_;  // P and Q in N, of the frames since
  std::optional<LoadHistory> other_;              // what the contact would be now with another friction
  std::vector<float> normal_pa_, true_pa_, other_pa_;
};

}  // namespace lab
