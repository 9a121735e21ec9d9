// How deep a sensor's taxels lie under its skin, by frames of presses: SubsurfaceFit at many depths, of which
// the likeliest is taken (docs/methods.md §23.8). Pulls during a press do no harm.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"

namespace sliplab {

// A frame of a press, Pa.
struct PressFrame {
  std::vector<float> normal_pa, shear_x_pa, shear_y_pa;
};

struct SkinDepth {
  // The likeliest depth, m. 0: less than a ninth of a taxel's side, which slipd takes for the surface.
  double depth_m = 0;
  // Its standard deviation, m, by noise or by the scatter of the frames' own depths, whichever is greater.
  double sigma_m = 0;
  // Frames that were used.
  std::size_t frames = 0;
  // Of all of them at the likeliest depth, nats: of two bases the likelier has the less.
  double misfit_nats = 0;
  // Standard deviation of the taxels' gains, a share; none: no taxel has enough frames.
  std::optional<double> gain_spread;
};

// The frames of presses among `frames`: those with at least a third of the greatest force, evenly chosen, at
// most `most`.
std::vector<PressFrame> press_frames(const slipd::TaxelLayout& layout, const std::vector<PressFrame>& frames,
                                     std::size_t most);

// None where no frame could be fitted. bonded_poisson: see Skin.
std::optional<SkinDepth> skin_depth(const slipd::TaxelLayout& layout, slipd::Range friction_expected,
                                    const std::vector<PressFrame>& presses,
                                    std::optional<double> bonded_poisson = std::nullopt);

}  // namespace sliplab
