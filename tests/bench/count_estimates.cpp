// count-estimates METHOD SIDE FRAMES [SENSORS]: the whole chain over so many frames of a simulated grasp, of
// each of so many sensors in turn; prints how many got a margin. It measures nothing itself:
// tools/instructions counts what two runs of different length execute.
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/scenes.hpp"

namespace {

constexpr std::size_t kFramesOfGrasp = 200;

int estimate(const std::string& method, std::size_t side, std::size_t frames, std::size_t sensors) {
  using namespace slipd::bench;
  const auto setup = setup_of(side, slipd::method_choices().at(method));
  const auto model = slipd::needs_model(setup) ? model_of(setup) : nullptr;
  std::vector<std::unique_ptr<slipd::EstimatorChain>> chains;
  for (std::size_t i = 0; i < sensors; ++i)
    chains.push_back(std::make_unique<slipd::EstimatorChain>(setup, model));
  Grasp grasp(side, kFramesOfGrasp);
  std::size_t answered = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const slipd::Frame& frame = grasp.next();
    for (const auto& chain : chains) answered += chain->estimate(frame).state == slipd::State::ok ? 1 : 0;
  }
  std::cout << answered << '\n';
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  if ((argc != 4 && argc != 5) || !slipd::method_choices().contains(argv[1])) {
    std::cerr << "usage: count-estimates METHOD SIDE FRAMES [SENSORS]\n";
    return 2;
  }
  return estimate(argv[1], std::stoul(argv[2]), std::stoul(argv[3]), argc > 4 ? std::stoul(argv[4]) : 1);
}
