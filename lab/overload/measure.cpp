#include "lab/overload/measure.hpp"

#include "tools/offline/parallel.hpp"

namespace lab {
namespace {

constexpr std::uint64_t kSkippingStream = 0x736B6970;  // apart from the noise of the frames

}  // namespace

OverloadLine measure_overload(const slipd::ChainSetup& chain,
                              const std::shared_ptr<const slipd::Model>& model, const OverloadCase& skipped,
                              const OverloadSetup& setup, const std::function<void(double)>& done) {
  struct Found {
    StatisticsByMove estimates;
    ErrorStatistics board;
  };
  std::vector<Found> found(setup.grasps);
  offline::for_each_index(
      setup.grasps, setup.threads,
      [&](std::size_t i) {
        slipd::EstimatorChain estimator(chain, model);
        const slipd::RandomStream draws = slipd::RandomStream(setup.seed).stream(i);
        Sampling sensing = setup.sensing;
        sensing.comes = comes(skipped.skipping, skipped.k, draws.stream(kSkippingStream));
        ErrorStatistics& board = found[i].board;
        found[i].estimates = drive(draw_grasp(chain.scene, setup.seed, i), chain.layout, chain.scene.skin,
                                   sensing, draws, estimator, [&board](const GraspSample& at) {
                                     if (at.move != Move::unseen) board.add(at.estimate, at.truth.gamma);
                                   });
      },
      [&](double share) {
        if (done) done(share);
      });
  OverloadLine line{.columns = 0, .method = {}, .skipped = skipped, .estimates = {}, .board = {}};
  for (const Found& grasp : found) {
    line.board.add(grasp.board);
    for (std::size_t move = 0; move < kMoves; ++move) {
      if (move != static_cast<std::size_t>(Move::unseen)) line.estimates.add(grasp.estimates[move]);
    }
  }
  return line;
}

}  // namespace lab
