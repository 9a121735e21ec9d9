// The angle by which the object has turned over the skin since the contact settled (docs/methods.md §31).
// The pressure's pattern turns with the object, and with it the directions of its moments of two, three and
// four arms about the contact's centre. A round contact has no such moments, and its angle is unknown.
// Estimate thread; fixed memory.
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <optional>

#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Checked with tests/core/sliding/turned_angle_test.cpp. side: a taxel's side; a: the contact's radius.
struct TurnedAngleOptions {
  // Time between frames that are used, s, 0.005 … 0.05; of slower sensors all frames are used. Too small:
  // costs time. Too large: more noise, and fast turns are ambiguous.
  double spacing_s = 0.02;
  // An angle with a larger standard deviation is not given; rad, 0.02 … 0.3. Too small: weak features give
  // none. Too large: angles are imprecise.
  double max_sigma_rad = 0.1;
};

struct TurnedAngle {
  // Since the contact settled, positive from x to y, not limited to one turn; rad.
  double angle_rad = 0;
  // Its standard deviation, rad, > 0.
  double sigma_rad = 0;
};

// Not thread-safe. Allocates nothing.
class TurnFollower {
 public:
  explicit TurnFollower(const TaxelLayout& layout, const TurnedAngleOptions& options = {});

  // The contact was lost.
  void forget() noexcept;
  // A frame in contact. `settled`: the grip has closed (FieldCourse::settled); angles are counted from then
  // on. `slides_turning`: force and torque are at the limit of friction. nullopt: the contact does not show
  // the angle, or has not settled.
  std::optional<TurnedAngle> update(std::int64_t time_ns, const ContactPatch& patch, bool settled,
                                    bool slides_turning) noexcept;

 private:
  static constexpr int kLeastArms = 2;
  static constexpr std::size_t kOrders = 3;  // two, three and four arms
  using Moments = std::array<std::complex<double>, kOrders>;
  // Of one frame: sum p (x + iy)^m over sum p r^2, lengths over a, and the standard deviation of each part by
  // noise.
  struct Pattern {
    Moments moments{};
    std::array<double, kOrders> noise{};
  };
  Pattern pattern_of(const ContactPatch& patch) const noexcept;
  void take(const ContactPatch& patch, bool settled) noexcept;
  std::optional<TurnedAngle> compare(double rim) const noexcept;
  bool pinned(std::int64_t time_ns, const TurnedAngle& now, bool slides_turning) noexcept;

  TurnedAngleOptions options_;
  double side_m_;
  bool can_;  // the layout has taxels
  Pattern newest_, reference_;
  int frames_ = 0;      // in the reference
  bool begun_ = false;  // there is a newest_
  bool ended_ = false;  // no angle until the contact is lost
  double angle_rad_ = 0;
  bool pinned_ = false;
  double pinned_angle_rad_ = 0;  // when it began to slide under its torque
  std::int64_t looked_ns_ = 0, known_ns_ = 0;
  std::optional<std::int64_t> slides_since_ns_;
  std::optional<TurnedAngle> answer_;
};

}  // namespace slipd
