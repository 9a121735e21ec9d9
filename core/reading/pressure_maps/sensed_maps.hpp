// The shear of a contact under a skin, explained by the maps of its own closing (docs/methods.md §25.4). The
// shear that pressing alone is sensed as is subtracted: it is in the maps. What is left is friction times the
// difference of two pressure maps, filtered by the ratio of the kernels. Each map is filtered when it is
// complete, not in every frame. What pressing is sensed as also shows the depth of the taxels. Estimate
// thread; nothing allocates after construction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/skin_depth.hpp"
#include "core/reading/pressure_maps/jaeger_decomposition.hpp"
#include "core/reading/pressure_maps/recorded_maps.hpp"
#include "core/reading/pressure_maps/shear_from_pressure_filter.hpp"

namespace slipd {

class SensedMaps {
 public:
  // layout: a regular grid. skin: of a depth above 0. trials: number of margins that are tried.
  SensedMaps(const TaxelLayout& layout, const Skin& skin, std::size_t trials);

  // Filters maps that have changed since, but not that of slot `filling`: of so many taxels, at least one.
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  void prepare(const RecordedMaps& maps, std::size_t taxels, std::size_t filling = kNone) noexcept;
  // Another contact: its depth is found anew.
  void forget() noexcept;
  // Whether all are filtered.
  bool ready(const RecordedMaps& maps) const noexcept;

  // A frame with a pull, under normal_n > 0; all maps are ready. To be called before those below.
  void read(const TaxelView& taxels, const RecordedMaps& maps, double normal_n) noexcept;

  // How a margin explains the shear that was read: by the difference between today's map and that of the
  // force that sticks.
  struct Pull {
    double x = 0, y = 0;      // friction times the pull's direction; both 0: not at all
    double residual_pa2 = 0;  // sum of squares, less what the maps' noise adds
    double noise_pa2 = 0;     // variance of one value's residual
    double map_share = 0;     // the maps' part of it
    double square_pa2 = 0;    // sum of squares of what a friction of 1 along the pull is sensed as
  };
  // trial: Gamma = (trial + 1/2) over their number.
  Pull pull(std::size_t trial) const noexcept;
  // How much better a load of another history explains it: the greatest gain of twice the log likelihood,
  // nats, by one more difference of maps.
  double history_gain(std::size_t trial, const Pull& pull) const noexcept;
  // Sum of squares of what was read, Pa^2, and of the shear alone, which is two values a taxel.
  double square_pa2() const noexcept { return frame_.square_pa2; }
  double shear_square_pa2() const noexcept { return frame_.shear_square_pa2; }
  // The part of their noise that what pressing is sensed as has, and so each frame alike; 0 … 1.
  double pressing_share() const noexcept { return frame_.pressing_share; }
  // How many values are in the first sum, and the variance of the noise of each, Pa^2.
  double values() const noexcept { return frame_.values; }
  double shear_pa2() const noexcept { return frame_.shear_pa2; }
  // The variance of that noise is itself measured, on differences that have neighbours in common: a mean
  // square varies by so much more than one of as many independent values.
  static constexpr double kOfMeasuredNoise = 4.8;
  // The shear that was read as a sum of maps, under any history of a load along a direction of length 1.
  // False: it is not known. read() has its normal_n.
  bool superpose(const RecordedMaps& maps, double normal_n, double direction_x, double direction_y,
                 JaegerDecomposition& out) noexcept;

  // The sum of squares of the pressure's difference from today's map, beyond noise, over that of the map. The
  // pressure that the pull is sensed as is left out: pressing is sensed as shear by the same kernel.
  double unlike(const RecordedMaps& maps, std::size_t trial, const Pull& pull) noexcept;
  // The same with the pull that superpose() has found.
  double unlike_superposed(const RecordedMaps& maps, double direction_x, double direction_y) noexcept;
  // After that: what the frame would read without the pull, for another map; until the next call.
  TaxelView without_pull(const RecordedMaps& maps) noexcept;

  // Changes what was read so that pull() gives what it would if the taxels lay deeper or less deep by
  // kDeeper, of the log of the depth.
  static constexpr double kDeeper = 0.1;
  void deepen(const RecordedMaps& maps, std::size_t trial, const Pull& pull) noexcept;
  // Of what is known of the log of the depth, standard deviation.
  double depth_sigma() const noexcept { return depth_.now().sigma; }

  // Beside the object itself.
  std::size_t memory_bytes() const noexcept;

 private:
  // Per map, in order of their forces, and one more for no contact.
  static constexpr int kMost = static_cast<int>(RecordedMaps::kMaps) + 1;
  using Weights = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
  using Products = std::array<RecordedMaps::PerMap, RecordedMaps::kMaps>;
  static constexpr std::size_t kChannels = 3;

  // Of pulls along x and y by two maps: sums over taxels of the products of what they are sensed as, Pa^2. By
  // slot, and in order of the forces.
  struct ProductsOfSlots {
    Products xx{}, xy{}, yy{};
  };
  struct Pulls {
    Square xx, xy, yy;
  };
  // What taxels sense of a pull along x and along y for a map: the shear's components, then the pressure.
  std::span<float> sensed_of(std::size_t slot, bool along_y) noexcept {
    return std::span(sensed_).subspan((2 * slot + (along_y ? 1 : 0)) * kChannels * taxels_,
                                      kChannels * taxels_);
  }
  std::span<const float> sensed_of(std::size_t slot, bool along_y) const noexcept {
    return std::span(sensed_).subspan((2 * slot + (along_y ? 1 : 0)) * kChannels * taxels_,
                                      kChannels * taxels_);
  }
  void filter(const RecordedMaps& maps, std::size_t map) noexcept;
  void find_depth(const RecordedMaps& maps) noexcept;
  void smooth(const RecordedMaps& maps) noexcept;
  // The map of a force as a sum of all, by Gaussian process regression.
  Weights at(const RecordedMaps& maps, double normal_n) const noexcept;
  // Of pulls along a direction.
  static Square of_pulls(const Pulls& of, double direction_x, double direction_y) noexcept {
    return direction_x * direction_x * of.xx + 2 * direction_x * direction_y * of.xy +
           direction_y * direction_y * of.yy;
  }
  static double product(const Square& of, const Weights& a, const Weights& b) noexcept {
    return a.dot(of.lazyProduct(b));
  }
  double noise_share(const Weights& weights) const noexcept { return weights.cwiseAbs2().dot(per_frames_); }
  // What the noise of a map of one frame adds to the products of what pulls are sensed as.
  double map_noise_pa2() const noexcept {
    return static_cast<double>(taxels_) * frame_.normal_pa2 *
           (ratio_.noise_gain() + frame_.pressure_weight * ratio_.pressing_gain());
  }
  void gather(const ProductsOfSlots& from, const RecordedMaps& maps, Pulls& out) const noexcept;
  void find_ways() noexcept;
  void weigh_pressure(const RecordedMaps& maps, double normal_n) noexcept;
  double explained_pa2(const RecordedMaps& maps, const Weights& of_x, const Weights& of_y,
                       double normal_n) const noexcept;
  void without_ways(std::span<float> pressure) const noexcept;
  void multiply(const RecordedMaps& maps) noexcept;
  double unlike(const RecordedMaps& maps, const Weights& slipping, double friction_x,
                double friction_y) noexcept;
  double noise_of(std::span<const float> values) const noexcept;

  const std::size_t taxels_, columns_, rows_;
  SkinDepth depth_;
  double filtered_log_ = 0;  // log of the depth that maps are filtered for, over the nominal one
  std::size_t last_filling_ = kNone;
  ShearFromPressureFilter ratio_;
  std::vector<float> sensed_;                                 // by slot of the maps
  std::array<std::uint64_t, RecordedMaps::kMaps> version_{};  // of the map that was filtered
  ProductsOfSlots as_shear_, as_pressure_;

  // Of all maps, when all are filtered.
  std::uint64_t smoothed_ = 0;  // the newest version
  Weights roots_, per_frames_;  // of the force over the last one's; 1 over the frames
  Square inverse_;              // of the covariance
  Pulls sensed_as_shear_, sensed_as_pressure_;

  // Whether a map was made of a frame with a pull: pressure then says no more of the pull than it did there.
  bool pulled_ = false;

  // Of the frame.
  // Both components of the shear, less what pressing is sensed as; then the pressure, less today's map and
  // all ways that it may have changed without a pull, times frame_.pressure_weight.
  std::vector<float> read_pa_;
  std::vector<float> pressure_pa_;  // less today's map
  // How today's map changes if it moves along x or y, or grows: kWays orthogonal vectors of length 1.
  static constexpr std::size_t kWays = 3;
  std::vector<float> ways_;
  std::vector<float> scratch_;
  struct ThisFrame {
    double pressure_weight = 0;  // of squares of the pressure, in sums with those of the shear
    double values = 0;           // number of independent values in read_pa_
    double square_pa2 = 0, shear_square_pa2 = 0;  // of read_pa_, and of the shear in it
    double shear_pa2 = 0, normal_pa2 = 0;         // variances of noise
    double pressing_share = 0;
    double map_pa2 = 0;  // mean square of today's map
  };
  ThisFrame frame_;
  Pulls pulls_;    // of both, weighted
  Weights today_;  // the map of its force
  // Of each trial: the difference of maps, its noise, and its products with noise taken off.
  struct Slipping {
    Weights weights;
    double noise_share = 0, xx = 0, xy = 0, yy = 0;
  };
  std::vector<Slipping> trials_;
  // Products of what was read with what is sensed of the maps; of the shear alone.
  Weights of_x_, of_y_, shear_of_x_, shear_of_y_;
  Weights superposed_;  // of the maps, with friction
};

}  // namespace slipd
