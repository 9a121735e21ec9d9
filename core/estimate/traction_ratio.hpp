// The share of the normal force that a contact carries as shear, |Q|/P, over a grasp's frames: of a sensor
// with shape each frame's own, of one without what the last few frames say, and where it tells that the
// object slides. Estimate thread; fixed memory.
#pragma once

#include <optional>

#include "core/estimate/friction_grid.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

class TractionRatioFilter {
 public:
  using Value = FrictionGrid::Value;

  static constexpr double kPlateau = 0.015;  // relative: Q/P this even while P changes is sliding

  explicit TractionRatioFilter(bool force_only) noexcept : force_only_(force_only) {}
  void clear() noexcept { *this = TractionRatioFilter(force_only_); }

  // One frame in contact.
  void update(const ContactPatch& patch) noexcept;

  const Value& now() const noexcept { return now_; }

  // What friction holds by now, and how many frames' worth of evidence one frame adds to it. Without shape it
  // is the frames' mean that tells: of the many frames of a slide those that noise put highest would speak
  // for too much.
  struct Held {
    Value load;
    double counts = 1;
  };
  Held held() const noexcept;

  // One frame's load, or as good as: the highest one of this grasp that look_for_sliding() has seen.
  bool is_highest(double load, double sigma) const noexcept;

  // After each frame. Coulomb: an object that slides keeps Q/P while P changes. Gives that Q/P while it does.
  // (While both grow from nothing a stuck contact does so too: P has to fall.)
  std::optional<double> look_for_sliding() noexcept;

 private:
  bool force_only_;
  Value now_;
  double frame_sigma_ = 0;  // of one frame's load
  double change_ = 0;       // a frame
  int frames_ = 0;          // that now_ and change_ come from
  double astray_ = 0;       // what frames were off of late, in their deviations
  double mean_ = 0;         // of a fixed number of frames
  Value normal_n_;          // the same of the normal force
  double highest_ = 0;
  double slide_normal_n_ = 0, slide_load_ = 0;  // where a plateau of Q/P may have begun
};

}  // namespace slipd
