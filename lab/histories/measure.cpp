#include "lab/histories/measure.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "lab/estimator.hpp"
#include "lab/grasp/drive.hpp"

namespace lab {
namespace {

using namespace slipd;

Grasp with_one_friction(Grasp grasp) {
  for (LoadSegment& segment : grasp.segments) segment.friction = grasp.contact.friction;
  return grasp;
}

// A range that the friction lies anywhere in, by the grasp's number.
std::optional<KnownFriction> given_friction(double friction, GivenFriction given, std::size_t grasp) {
  constexpr double kWidth = 1.6;  // high over low
  if (given == GivenFriction::none || given == GivenFriction::constant) return std::nullopt;
  if (given == GivenFriction::value) return KnownFriction(friction);
  const double low = friction / std::pow(kWidth, RandomStream(0x746f6c64).uniform(grasp));
  return KnownFriction(Range{low, kWidth * low});
}

void write_traced(std::ostream& out, const GraspSample& sample) {
  const GraspMoment& at = sample.at;
  const Estimate& estimate = sample.estimate();
  out << at.time_s << ',' << name_of(static_cast<Move>(at.move)) << ',' << at.normal_n << ',' << at.shear_n
      << ',' << at.truth.gamma << ',' << estimate.gamma.value_or(kUnknown) << ','
      << estimate.sigma.value_or(kUnknown) << ',' << to_string(estimate.state) << '\n';
}

}  // namespace

HistoriesLine measure_moves(std::size_t side, const std::string& method, const HistoriesSetup& setup,
                            std::uint64_t seed, const Done& done) {
  ChainSetup scene = paper_chain(side, method_choices().at(method), setup.sensing.noise);
  scene.scene.skin.depth_m = 1e-3 * setup.skin_mm;
  Skin sensed = scene.scene.skin;
  sensed.base = setup.base;
  scene.scene.skin.base = setup.base_taken;
  scene.scene.skin.depth_m *= setup.depth_taken;
  const Estimator estimator = make_estimator(scene, setup.threads);
  std::ostringstream traced;
  traced << "time_s,move,normal_n,shear_n,truth,gamma,sigma,state\n";
  const auto play = [&](std::size_t i) {
    Grasp grasp = draw_grasp(scene.scene, seed, i);
    if (setup.friction != GivenFriction::none) grasp = with_one_friction(std::move(grasp));
    Estimator known = estimator;
    known.setup.friction = given_friction(grasp.contact.friction, setup.friction, i);
    EstimatorChain chain = known.chain();
    RandomFrames frames(std::move(grasp), scene.layout, sensed, setup.sensing, RandomStream(seed).stream(i));
    TalliesByMove tallies;
    drive(frames, chain, [&](const GraspSample& sample) {
      tallies.at(sample.at.move).add(sample.estimate(), sample.at.truth);
      if (i == 0) write_traced(traced, sample);
    });
    return tallies;
  };
  HistoriesLine line{.side = side, .method = method, .all = {}, .first_grasp = {}};
  for (const TalliesByMove& grasp : collect(setup.grasps, setup.threads, done, play)) {
    Tally whole;
    for (std::size_t move = 0; move < kMoves; ++move) {
      line.by_move[move].add(grasp[move]);
      if (move != static_cast<std::size_t>(Move::unseen)) whole.add(grasp[move]);
    }
    line.all.add(whole);
    line.low_above.add(whole.lows_above(), whole.lows());
    line.low_clearly_above.add(whole.lows_clearly_above(), whole.lows());
  }
  line.first_grasp = traced.str();
  return line;
}

}  // namespace lab
