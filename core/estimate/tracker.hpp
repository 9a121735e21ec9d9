// Friction over time. A frame whose load has only risen tells friction by itself; after a regrip, an
// unloading or a reversal no frame does, and the margin is 1 - |Q|/(mu P) with the friction remembered.
// Friction is believed to fall at once and to rise only slowly, because the one mistake that drops an object
// is to think it higher than it is.
#pragma once

#include <cstdint>
#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "core/estimate/friction_grid.hpp"
#include "core/estimate/growth.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/settings.hpp"

namespace slipd {

class Tracker {
 public:
  // friction_expected: the scene's range. friction: known beforehand, never unlearnt. few_taxels: no single
  // frame of this sensor tells its margin; friction is weighed over a grasp's frames instead.
  Tracker(const EstimatorSettings& settings, Range friction_expected, std::optional<double> friction,
          bool few_taxels);

  // Estimate thread. Fills in state, gamma, sigma, friction and method of `out`, whose forces and sequence
  // are set. `reading` is null where the sensor has no method of its own (one force vector, flat skin).
  void update(const ContactPatch& patch, const Reading* reading, Method method, Estimate& out) noexcept;

  // The contact was lost: what was learnt of this object is forgotten.
  void forget() noexcept;

 private:
  struct Belief {
    double mean = 0, sigma = 0;
  };
  struct Margin {
    double gamma = 0, sigma = 0;
  };
  static Margin fuse(const Margin& a, const Margin& b) noexcept;
  static bool agree(const Margin& a, const Margin& b) noexcept;
  bool rim_slips(const RimReading& rim, double load, double load_sigma) const noexcept;
  Margin from_scene(double load, double load_sigma) const noexcept;
  Margin from_belief(double load, double load_sigma) const noexcept;
  void update_few(const ContactPatch& patch, const Reading* reading, Estimate& out) noexcept;
  void learn(double friction, double sigma, std::int64_t time_ns) noexcept;

  EstimatorSettings settings_;
  Range expected_;
  std::optional<Belief> given_, belief_;
  std::optional<FrictionGrid> grid_;
  Growth growth_;
  std::int64_t learnt_ns_ = 0;
};

}  // namespace slipd
