// Friction weighed over a grasp's frames, for sensors of which no single frame tells it: 4 x 4 taxels, flat
// pads, one force vector. Every friction that may be is kept with its weight, and each frame multiplies the
// weights by how well it fits. Estimate thread; fixed memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/method.hpp"

namespace slipd {

class FrictionGrid {
 public:
  explicit FrictionGrid(Range expected);

  // A new grasp: back to what the scene expects.
  void reset() noexcept;

  // load = Q/P >= 0 with its deviation. `profile`: how little each Gamma fits the frame, null where the frame
  // has no shape. Only a frame whose load is the highest of the grasp so far is of the family that a profile
  // speaks of.
  void update(std::int64_t time_ns, double normal_n, double load, double load_sigma,
              const MarginProfile* profile) noexcept;

  struct Belief {
    double mean = 0, sigma = 0;
  };
  Belief belief() const noexcept;

  // Mean and deviation of Gamma = 1 - load/mu over all friction.
  Belief margin(double load, double load_sigma) const noexcept;

 private:
  static constexpr std::size_t kCount = 96;
  static constexpr double kLow = 0.03, kHigh = 2.0;  // friction, evenly spaced in its logarithm

  void weigh_sliding(double normal_n, double load, double load_sigma) noexcept;
  void normalise() noexcept;

  std::array<double, kCount> friction_, prior_, weight_;  // log weights, the greatest is 0
  std::int64_t last_ns_ = 0;
  double highest_load_ = 0;
  double slide_normal_n_ = 0, slide_load_ = 0;  // where a plateau of Q/P may have begun
};

}  // namespace slipd
