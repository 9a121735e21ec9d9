// What friction this grasp may have, weighed over its frames. Each friction that may be lives through the
// grasp's forces with a contact of its own (WinklerFoundations), and each frame takes weight from those whose
// contact would look otherwise by now: after a regrip, an unloading or a reversal just as while a load only
// rises. What no frame tells apart stays open: a contact that sticks all over looks the same for every
// friction that holds it.
//
// A change of friction is believed within a few frames that speak for it, and sooner if it fell than if it
// rose. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/contact/scene.hpp"
#include "core/estimate/friction_grid.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/traction_ratio.hpp"
#include "core/estimate/winkler_foundations.hpp"

namespace slipd {

class FrictionFilter {
 public:
  // The range expected ends softly, over about `spread` of log mu. `shapeless`: frames of this sensor tell
  // little of their own, so that sliding is told by Q/P, which keeps while P changes.
  FrictionFilter(Range expected, double spread, bool force_only);

  // A new grasp: back to what the scene expects.
  void reset() noexcept;

  // One frame in contact, in order of time. `reading` is null where the frame has no shape.
  void update(std::int64_t time_ns, const ContactPatch& patch, const FrameEstimate* frame_estimate) noexcept;

  const FrictionGrid& weights() const noexcept { return weights_; }

  // |Q|/P now: of sensors without shape what the last few frames say of it, since nothing else tells their
  // margin.
  const FrictionGrid::Value& load() const noexcept { return carried_.now(); }

  // The likeliest friction's contact is one whose load has only risen.
  bool monotonic() const noexcept { return monotonic_; }
  // This frame does not look as the friction believed before it would have it: that has changed, or was
  // wrong.
  bool surprised() const noexcept { return surprised_; }
  // So do the frames of late, if by less: how much less friction there is they do not tell.
  bool doubted() const noexcept { return doubted_ > 0; }
  // The frames of late look as some friction would have them, after a history that is known.
  bool understood() const noexcept { return known_ && misfit_ < kMostMisfit; }

 private:
  // Contacts to follow are dear: as many as frames with a shape tell apart. Without a shape there are none.
  static constexpr std::size_t kContacts = 56, kForceOnly = FrictionGrid::kMost;
  static constexpr double kMostMisfit = 4;  // mean square, 1 where all is understood
  using PerFriction = std::array<double, FrictionGrid::kMost>;

  void follow(const ContactPatch& patch) noexcept;
  void watch_begin(const ContactPatch& patch) noexcept;
  void start_anew() noexcept;
  void weigh_frame(const ContactPatch& patch, const FrameEstimate& frame_estimate) noexcept;
  // How badly each friction explains the frame: squared deviations.
  void misfit_of_margin(double load, const FrameEstimate& frame_estimate, PerFriction& misfit) const noexcept;
  void misfit_of_shear_moments(const ContactPatch& patch, const FrameEstimate& frame_estimate,
                               PerFriction& misfit) noexcept;
  void judge(const PerFriction& misfit, bool direct) noexcept;
  void watch_jumps() noexcept;
  bool looks_monotonic(double normal_n, double load) const noexcept;
  void weaken() noexcept;
  void weigh_sliding(double load) noexcept;

  FrictionGrid weights_;
  bool force_only_;
  TractionRatioFilter carried_;
  WinklerFoundations contacts_;
  double normal_n_ = 0, shear_n_ = 0;  // as the contacts were told, shear signed along the axis
  double axis_x_ = 0, axis_y_ = 0;     // 0 while there was no shear
  double aimed_n_ = 0;                 // the shear that the axis was taken from
  bool known_ = true, monotonic_ = true, surprised_ = false;
  double told_ = 0;      // by profiles, in frames' worth of what they all have in common
  int doubted_ = 0;      // frames for which no margin means anything yet
  double believed_ = 0;  // the likeliest friction a frame ago, 0 before there was one
  double misfit_ = 1, cusum_ = 0;
  double off_slip_moment_n_ = 0, off_second_legendre_n_ = 0;  // of the contact believed in, over some frames
  int strange_ = 0;   // frames one after the other that no friction explains
  int agreeing_ = 0;  // frames that a risen load explains since the past was lost
  int frames_ = 0;    // of this grasp, as long as it begins
  double first_normal_n_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace slipd
