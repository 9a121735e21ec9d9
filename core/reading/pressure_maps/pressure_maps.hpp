// The margin of a contact of any shape (docs/methods.md §25). A contact that was pressed and then pulled has
// the shear q = mu (p(P) - p(P*)) with Gamma = P*/P (Ciavarella 1998a, 1998b; Jäger 1998), where p(P) is its
// pressure under the normal force P. These pressures were recorded while the gripper closed. So the method
// assumes no radius and no shape, and gains that a taxel's axes share, and dead taxels, cancel. Exact for
// axisymmetric and plane contacts of similar materials; for others the error is some per cent of the shear.
// Under a skin: SubsurfacePressureMaps.
#pragma once

#include <cstddef>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/pressure_maps/jaeger_decomposition.hpp"
#include "core/reading/pressure_maps/margin_trials.hpp"
#include "core/reading/pressure_maps/recorded_maps.hpp"

namespace slipd {

// Dimensionless. Checked with tests/core/reading/pressure_maps/pressure_maps_test.cpp.
struct PressureMapsOptions {
  FrictionPriorOptions prior;

  // Frames with a pull are recorded, too, if their pressure is the one that the maps go on to, up to this
  // factor; 1.1 … 1.5. Too small: a quick regrip takes the margin away. Too large: maps do not go on so far,
  // and a contact that has moved meanwhile is taken for one that has grown.
  double most_step = 1.2;
  // The least number of maps for a margin; 4 … 32. Too few: interpolation between them is wrong. Too many: a
  // quick grip has no margin.
  std::size_t least_maps = 8;
};

class PressureMaps final : public SlipMethod {
 public:
  // friction_expected: the scene's range; decides only where the frame itself leaves the margin open.
  PressureMaps(const TaxelLayout& layout, Range friction_expected, const PressureMapsOptions& options = {});
  Method name() const noexcept override { return Method::closing; }
  MethodSettings settings() const noexcept override {
    return {.memory_bytes = sizeof(*this) + maps_.memory_bytes() + sizeof(float) * shear_pa_.size()};
  }

  // Records the frame if the gripper closes and nothing pulls.
  void observe(const Frame& frame, const ContactPatch& patch) noexcept override;
  // Another contact: its closing is recorded anew.
  void forget() noexcept override { maps_.clear(); }

  // Not in the model if the closing was not recorded from its beginning, if the contact has moved since, or
  // if the shear is no difference of two maps: another load history.
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

 private:
  bool recorded(double normal_n) const noexcept;
  // Whether the grip has tightened since it closed. Its pressure is that of closing, whatever pulls.
  bool grown(const ContactPatch& patch) noexcept;
  bool unmoved(const ContactPatch& patch, const RecordedMaps::Sum& today) const noexcept;
  // Shear along the pull goes to shear_pa_. Both sums of squares are over the contact, Pa^2.
  struct Shear {
    double along_pa2 = 0;
    double across_pa2 = 0;  // beyond noise; none of a load that came in one direction
  };
  Shear read_shear(const ContactPatch& patch) noexcept;
  // products: of maps and shear.
  MarginTrial judge(double gamma, const ContactPatch& patch, const RecordedMaps::Sum& today,
                    const RecordedMaps::PerMap& products, double shear_square_pa2) const noexcept;
  // False: nothing is known.
  bool superpose(const ContactPatch& patch, const RecordedMaps::PerMap& products, double shear_square_pa2,
                 JaegerDecomposition& out) const noexcept;

  const TaxelLayout layout_;
  const PressureMapsOptions options_;
  RecordedMaps maps_;
  std::vector<float> shear_pa_;  // of the frame, along the pull
  MarginTrials trials_;          // of the frame
};

}  // namespace slipd
