// Pressure maps (pressure_maps.hpp) under a skin of known depth, on regular grids: the shear is compared with
// the maps as the taxels sense them (docs/methods.md §25.4). Gains and dead taxels do not cancel here.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "core/contact/scene.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/pressure_maps/jaeger_decomposition.hpp"
#include "core/reading/pressure_maps/margin_trials.hpp"
#include "core/reading/pressure_maps/pressure_maps.hpp"
#include "core/reading/pressure_maps/recorded_maps.hpp"
#include "core/reading/pressure_maps/sensed_maps.hpp"

namespace slipd {

// Dimensionless. Checked with tests/core/reading/pressure_maps/subsurface_pressure_maps_test.cpp.
struct SubsurfacePressureMapsOptions {
  PressureMapsOptions maps;

  // Shear is recorded as well, so nothing pulls up to this share of P, and a force is the greatest recorded
  // one; 0.001 … 0.02. Too small: a sensor that reads shear under a normal load records nothing, and noise of
  // forces makes maps of loaded frames. Too large: the beginning of a pull is taken for what pressing is
  // sensed as, and the contact has grown beyond its maps.
  double most_shear_sensed = 0.005;
};

class SubsurfacePressureMaps final : public SlipMethod {
 public:
  // skin: of a depth above 0, and one that can_read the layout. friction_expected: as of PressureMaps.
  SubsurfacePressureMaps(const TaxelLayout& layout, Range friction_expected, const Skin& skin,
                         const SubsurfacePressureMapsOptions& options = {});
  // Whether taxels of such a layout can be read under such a skin: on regular grids under half spaces only.
  static bool can_read(const TaxelLayout& layout, const Skin& skin) noexcept {
    return layout.regular().has_value() && skin.base == SkinBase::half_space;
  }
  Method name() const noexcept override { return Method::closing; }
  MethodSettings settings() const noexcept override {
    return {.memory_bytes = sizeof(*this) + maps_.memory_bytes() + sensed_.memory_bytes()};
  }

  void observe(const Frame& frame, const ContactPatch& patch) noexcept override;
  void forget() noexcept override;
  // Not in the model where PressureMaps is not. With normal_n and shear_n of the frame, N, as taxels sense
  // more of a pull than its shear.
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

 private:
  // The force that maps are sorted by, of all taxels: a disc reads another share of the force of each
  // contact.
  double force_n(const ContactPatch& patch) const noexcept;
  bool recorded(double normal_n) const noexcept;
  MarginTrial judge(std::size_t step, const ContactPatch& patch) const noexcept;
  // All trials of the frame that sensed_ has read. Returns the most likely one, with the prior.
  std::optional<std::size_t> judge(const ContactPatch& patch) noexcept;
  struct SensedFrame {
    std::optional<std::size_t> best;  // trial
    JaegerDecomposition sum{1};
    bool summed = false;
  };
  // None if maps are not ready, or the contact has moved.
  std::optional<SensedFrame> read(const ContactPatch& patch, double normal_n) noexcept;
  // The same, after the grip has tightened since it closed: with another map of the frame's force.
  std::optional<SensedFrame> read_grown(const ContactPatch& patch, double normal_n,
                                        const SensedFrame& before) noexcept;
  void give_moments(const JaegerDecomposition& sum, Reading& out) const noexcept;
  // What the depth's standard deviation makes of the margin.
  double sigma_by_depth(const ContactPatch& patch, std::size_t best, double gamma) noexcept;

  const TaxelLayout layout_;
  const SubsurfacePressureMapsOptions options_;
  RecordedMaps maps_;
  SensedMaps sensed_;
  double most_n_ = 0;    // the greatest force that was recorded
  double pulled_n_ = 0;  // the greatest force with a pull, N
  MarginTrials trials_;  // of the frame
  // How much Gamma changes with the depth's standard deviation, and at which Gamma that was found.
  double by_depth_ = 0, asked_at_gamma_ = std::numeric_limits<double>::infinity();
};

}  // namespace slipd
