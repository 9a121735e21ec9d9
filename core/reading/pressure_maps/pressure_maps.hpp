// The margin of a contact of any shape (docs/methods.md §25). A contact that was pressed and then pulled has
// the shear q = mu (p(P) - p(P*)) with Gamma = P*/P (Ciavarella 1998a, 1998b; Jäger 1998), where p(P) is its
// pressure under the normal force P. These pressures were recorded while the gripper closed. So the method
// assumes no radius and no shape, and gains that a taxel's axes share, and dead taxels, cancel. Exact for
// axisymmetric and plane contacts of similar materials; for others the error is some per cent of the shear.
// Under a skin of known depth SubsurfacePressureMaps compares the shear with the maps, on regular grids;
// gains and dead taxels do not cancel there.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/pressure_maps/jaeger_decomposition.hpp"
#include "core/reading/pressure_maps/recorded_maps.hpp"
#include "core/reading/pressure_maps/subsurface_pressure_maps.hpp"

namespace slipd {

// Dimensionless unless a unit is given. Checked with tests/core/reading/pressure_maps/pressure_maps_test.cpp.
struct PressureMapsOptions {
  FrictionPriorOptions prior;

  // Under a skin, where shear is recorded as well, nothing pulls up to this share of P, and a force is the
  // greatest recorded one; 0.001 … 0.02. Too small: a sensor that reads shear under a normal load records
  // nothing, and noise of forces makes maps of loaded frames. Too large: the beginning of a pull is taken for
  // what pressing is sensed as, and the contact has grown beyond its maps.
  double most_shear_sensed = 0.005;
  // Beyond that, frames with a pull are recorded, too, if their pressure is the one that the maps go on to,
  // up to this factor; 1.1 … 1.5. Too small: a quick regrip takes the margin away. Too large: maps do not go
  // on so far, and a contact that has moved meanwhile is taken for one that has grown.
  double most_step = 1.2;
  // The least number of maps for a margin; 4 … 32. Too few: interpolation between them is wrong. Too many: a
  // quick grip has no margin.
  std::size_t least_maps = 8;
};

class PressureMaps final : public SlipMethod {
 public:
  // friction_expected: the scene's range; decides only where the frame itself leaves the margin open.
  // skin: of a depth above 0 only for layouts that can_read.
  PressureMaps(const TaxelLayout& layout, Range friction_expected, const Skin& skin = {},
               const PressureMapsOptions& options = {});
  // Whether such a layout can be read under such a skin: on regular grids under half spaces only.
  static bool can_read(const TaxelLayout& layout, const Skin& skin) noexcept {
    return !(skin.depth_m > 0) || (layout.regular().has_value() && skin.base == SkinBase::half_space);
  }
  Method name() const noexcept override { return Method::closing; }
  MethodSettings settings() const noexcept override {
    return {.memory_bytes = sizeof(*this) + maps_.memory_bytes() + sizeof(float) * shear_pa_.size() +
                            (skin_ ? skin_->memory_bytes() : 0)};
  }

  // Records the frame if the gripper closes and nothing pulls.
  void observe(const Frame& frame, const ContactPatch& patch) noexcept override;
  // Another contact: its closing is recorded anew.
  void forget() noexcept override {
    maps_.clear();
    most_n_ = pulled_n_ = 0;
    if (skin_) skin_->forget();
    asked_at_gamma_ = std::numeric_limits<double>::infinity();
  }

  // Not in the model if the closing was not recorded from its beginning, if the contact has moved since, or
  // if the shear is no difference of two maps: another load history.
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

 private:
  // Trial margins, evenly in 0 … 1.
  static constexpr std::size_t kStepsOfProfile = 5;  // odd: one lies in the middle of a profile's step
  static constexpr std::size_t kSteps = kStepsOfProfile * MarginProfile::kSteps;
  static constexpr double gamma_of(std::size_t step) noexcept {
    return (static_cast<double>(step) + 0.5) / kSteps;
  }

  // How one trial margin explains the shear.
  struct Trial {
    double gamma = 0;
    double friction = 0;      // most likely with the prior, > 0; 0: nothing is known
    double nats = 0;          // against this friction
    double misfit = 0;        // half the squared residual in units of noise, and half the logarithm of noise
    double residual_pa2 = 0;  // sum of squares
    double noise_pa2 = 0;     // variance of one taxel's residual
    double map_share = 0;     // the maps' part of it
  };

  // The force that maps are sorted by. Under a skin that of all taxels: a disc reads another share of the
  // force of each contact.
  double force_n(const ContactPatch& patch) const noexcept;
  bool recorded(double normal_n) const noexcept;
  // Whether the grip has tightened since it closed. Its pressure is that of closing, whatever pulls.
  bool grown(const ContactPatch& patch, double normal_n) noexcept;
  bool unmoved(const ContactPatch& patch, const RecordedMaps::Sum& today) const noexcept;
  Trial judge(double gamma, const ContactPatch& patch, const RecordedMaps::Sum& today,
              const RecordedMaps::PerMap& products, double shear_square_pa2) const noexcept;
  void weigh_friction(double measured, double square_pa2, Trial& trial) const noexcept;
  // The same under a skin, of the frame that skin_ has read; without the misfit.
  Trial judge_sensed(std::size_t step, const ContactPatch& patch) const noexcept;
  // All trials. Returns the most likely one, with the prior; kSteps: none.
  std::size_t judge_sensed(const ContactPatch& patch) noexcept;
  // The one that leaves least; kSteps: none.
  std::size_t closest_trial() const noexcept;
  // The most likely of the trials, with the prior; null: none.
  const Trial* best_trial() const noexcept;
  Reading estimate_sensed(const ContactPatch& patch) noexcept;
  struct SensedFrame {
    std::size_t best = kSteps;  // trial; kSteps: none
    JaegerDecomposition sum{1};
    bool summed = false;
  };
  // False if maps are not ready, or the contact has moved.
  bool read_sensed(const ContactPatch& patch, double normal_n, SensedFrame& out) noexcept;
  double sigma_by_depth(const ContactPatch& patch, std::size_t best, double gamma) noexcept;
  // Fills sigma and friction of `out` from the likelihood. excess: sum of squares that noise does not
  // explain, explained: that the pull does, noise: the deviation of the first; Pa^2.
  struct Squares {
    double excess_pa2 = 0, noise_pa2 = 0, explained_pa2 = 0;
  };
  void conclude(const ContactPatch& patch, const Trial& best, const Squares& squares,
                Reading& out) const noexcept;
  // The shear moments of any history, and under a skin the forces, if the maps explain the shear.
  void give_moments(const JaegerDecomposition& sum, const Squares& squares, Reading& out) const noexcept;
  // Without a skin. products: of maps and shear. False: nothing is known.
  bool superpose(const ContactPatch& patch, const RecordedMaps::PerMap& products, double shear_square_pa2,
                 JaegerDecomposition& out) const noexcept;
  // The share of the shear that is not explained, where that is clearly more than noise; else 0.
  double unexplained_share(const Squares& squares) const noexcept;
  void weigh(Reading& out) const noexcept;
  void give_profile(Reading& out) const noexcept;

  const TaxelLayout layout_;
  const FrictionPrior prior_;
  const PressureMapsOptions options_;
  RecordedMaps maps_;
  std::optional<SubsurfacePressureMaps> skin_;  // of a depth above 0
  double most_n_ = 0;                           // the greatest force that was recorded
  double pulled_n_ = 0;                         // under a skin: the greatest force with a pull, N
  std::vector<float> shear_pa_;                 // along the pull
  std::array<Trial, kSteps> trials_;
  // How much Gamma changes with the depth's standard deviation, and at which Gamma that was found.
  double by_depth_ = 0, asked_at_gamma_ = std::numeric_limits<double>::infinity();
};

}  // namespace slipd
