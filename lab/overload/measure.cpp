#include "lab/overload/measure.hpp"

#include "lab/frames/random_frames.hpp"
#include "lab/grasp/drive.hpp"

namespace lab {
namespace {

constexpr std::uint64_t kSkippingStream = 0x736B6970;  // apart from the noise of the frames

struct BoardAndEstimates {
  Tally estimates, board;
};

BoardAndEstimates play(const Estimator& estimator, const OverloadCase& skipped, const OverloadSetup& setup,
                       std::size_t grasp) {
  const slipd::ChainSetup& chain = estimator.setup;
  const slipd::RandomStream draws = slipd::RandomStream(setup.seed).stream(grasp);
  RandomFrames frames(draw_grasp(chain.scene, setup.seed, grasp), chain.layout, chain.scene.skin,
                      setup.sensing, draws);
  slipd::EstimatorChain estimates = estimator.chain();
  BoardAndEstimates found;
  drive(frames, estimates,
        [&](const GraspSample& sample) {
          if (sample.at.move == static_cast<std::size_t>(Move::unseen)) return;
          if (sample.received) found.estimates.add(sample.estimate(), sample.at.truth);
          found.board.add(sample.estimate(), sample.at.truth);
        },
        {.comes = comes(skipped.skipping, skipped.k, draws.stream(kSkippingStream))});
  return found;
}

}  // namespace

OverloadLine measure_overload(const Estimator& estimator, const OverloadCase& skipped,
                              const OverloadSetup& setup, const Done& done) {
  OverloadLine line{.columns = 0, .method = {}, .skipped = skipped, .estimates = {}, .board = {}};
  for (const BoardAndEstimates& grasp : collect(setup.grasps, setup.threads, done, [&](std::size_t i) {
         return play(estimator, skipped, setup, i);
       })) {
    line.estimates.add(grasp.estimates);
    line.board.add(grasp.board);
  }
  return line;
}

}  // namespace lab
