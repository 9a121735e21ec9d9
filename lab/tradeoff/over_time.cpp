#include "lab/tradeoff/over_time.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lab/frames/random_frames.hpp"
#include "lab/grasp/drive.hpp"
#include "lab/tally/samples.hpp"
#include "lab/tally/tally.hpp"

namespace lab {
namespace {

using namespace slipd;

// As draw_grasp, with the first slip as second segment, and no change of friction afterwards.
Grasp slipping_grasp(const Scene& scene, std::uint64_t seed, std::size_t index) {
  Grasp grasp = draw_grasp(scene, seed, index, 0);
  grasp.segments.resize(1);
  const RandomStream random = RandomStream(seed ^ 0x736c6970ULL).stream(index);
  LoadSegment last = grasp.segments.front();
  const auto add = [&](Move move, double normal_n, double share, double seconds) {
    const double most = last.friction * normal_n;
    last = {move, normal_n, share * most, last.friction, seconds};
    grasp.segments.push_back(last);
    last.shear_n = std::min(last.shear_n, most);
  };
  add(Move::slide, last.normal_n, 1.1, random.uniform(0, 0.1, 1.0));
  for (std::uint64_t i = 1; i <= 5; ++i) {
    const double share = random.uniform(3 * i), seconds = random.uniform(3 * i + 1, 0.05, 0.4);
    const bool regrips = random.uniform(3 * i + 2) < 0.3;
    const double normal_n = regrips ? std::min(5.0, 1.3 * last.normal_n) : last.normal_n;
    add(regrips ? Move::tighten : Move::load, normal_n, share, seconds);
  }
  return grasp;
}

struct Part {
  const char* name;
  Tally tally{};
  Samples errors{}, times_us{};
};

Line line_of(const std::string& layout, const Noise& noise, Method method, const Part& part) {
  Line line{layout, noise, part.name, {}, {kUnknown, kUnknown}, false};
  line.row.method = to_string(method);
  line.row.mean_error = part.tally.mean_error();
  line.row.p95_error = part.errors.quantile(0.95);
  line.row.right = part.tally.class_correct();
  line.row.answered = part.tally.answered();
  line.row.within_sigma = part.tally.within(1);
  line.row.within_two_sigma = part.tally.within(2);
  line.row.p50_us = part.times_us.median();
  line.row.p99_us = part.times_us.quantile(0.99);
  return line;
}

}  // namespace

std::vector<Line> measure_over_time(const std::string& layout, const TaxelLayout& taxels, const Scene& scene,
                                    const Noise& noise, std::size_t grasps, std::uint64_t seed) {
  const ChainSetup setup{.layout = taxels,
                         .sensor_class = taxels.size() == 1 ? SensorClass::wrench : SensorClass::array3,
                         .scene = scene,
                         .estimator = {},
                         .alerts = {},
                         .friction = {}};
  std::array<Part, 2> parts{Part{.name = "before the first slip"}, Part{.name = "after it"}};
  const Sampling sampling{.kind = noise.kind, .noise = noise.half_width};
  Method method = Method::none;
  for (std::size_t i = 0; i < grasps; ++i) {
    EstimatorChain chain(setup, nullptr);
    method = chain.method();
    bool slipped = false;
    RandomFrames frames(slipping_grasp(scene, seed, i), taxels, scene.skin, sampling,
                        RandomStream(seed).stream(i));
    drive(frames, chain, [&](const GraspSample& sample) {
      const Estimate& estimate = sample.estimate();
      const Truth& truth = sample.at.truth;
      Part& part = parts[slipped ? 1 : 0];
      part.tally.add(estimate, truth);
      if (estimate.gamma) part.errors.add(std::fabs(*estimate.gamma - truth.gamma));
      part.times_us.add(sample.taken_us.front());
      slipped = slipped || truth.gamma < 1e-9;
    });
  }
  std::vector<Line> lines;
  lines.reserve(parts.size());
  for (const Part& part : parts) lines.push_back(line_of(layout, noise, method, part));
  return lines;
}

}  // namespace lab
