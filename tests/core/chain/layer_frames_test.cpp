// Frames of spheres pressed and pulled on a layer, 1 mm thick, bonded to a rigid base, Poisson's ratio 0.45,
// from a solver that shares no equation with slipd's contact model: the pressure that the layer's own surface
// displacement makes of a sphere, |q| <= mu p and the least elastic energy with the layer's own tangential
// displacement, radii of 1 to 4 mm (tests/data/layer-contacts.bin: friction, margin, radius in m and peak
// pressure in Pa of a frame, then counts of three channels of 32 x 32 taxels on +-8 mm, 32000 of the peak).
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <random>
#include <vector>

#include "core/patch/patch.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

constexpr std::size_t kLayerAcross = 32, kTaxels = kLayerAcross * kLayerAcross;

struct LayerFrame {
  double gamma = 0, radius_m = 0;
  std::array<std::vector<float>, 3> channels;  // Pa
};

// With noise of 1 % of the peak.
std::vector<LayerFrame> layer_frames() {
  std::ifstream in(SLIPD_SOURCE_DIR "/tests/data/layer-contacts.bin", std::ios::binary);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> noise(-0.01, 0.01);
  std::vector<LayerFrame> frames;
  std::array<double, 4> head{};
  std::vector<std::int16_t> counts(3 * kTaxels);
  while (in.read(reinterpret_cast<char*>(head.data()), sizeof head) &&
         in.read(reinterpret_cast<char*>(counts.data()), 3 * kTaxels * sizeof(std::int16_t))) {
    LayerFrame frame{.gamma = head[1], .radius_m = head[2], .channels = {}};
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < kTaxels; ++i)
        frame.channels[c].push_back(
            static_cast<float>(head[3] * (counts[c * kTaxels + i] / 32000.0 + noise(random))));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

// A contact as wide as the layer is thick is Hertz's; wider ones are not (docs/theory.md §5.5), which sigma
// has to tell.
TEST(LayerFrames, AreReadWithinTwoSigmasOrTooLittleMargin) {
  const TaxelLayout layout = TaxelLayout::grid(kLayerAcross, kLayerAcross, 0.0005);
  PatchFinder finder(layout);
  SubsurfaceFit fit(layout, {0.1, 0.9}, 0.001, {}, {}, 0, 0.45);
  double error = 0, answered = 0;
  const std::vector<LayerFrame> frames = layer_frames();
  ASSERT_GT(frames.size(), 20U);
  for (const LayerFrame& frame : frames) {
    const ContactPatch& patch = finder.find({1, 1, frame.channels[0], frame.channels[1], frame.channels[2]});
    const Reading estimate = fit.estimate(patch, moment_ratio(patch, layout));
    if (!estimate.in_model) continue;
    answered += 1;
    error += std::fabs(estimate.gamma - frame.gamma);
    EXPECT_LT(estimate.gamma, frame.gamma + 2 * estimate.sigma + 0.01) << 1e3 * frame.radius_m << " mm";
    EXPECT_LT(estimate.gamma, frame.gamma + 0.15) << 1e3 * frame.radius_m << " mm";
  }
  EXPECT_GT(answered, 0.8 * static_cast<double>(frames.size()));
  EXPECT_LT(error / answered, 0.05);
}

}  // namespace
}  // namespace slipd
