// count-estimates METHOD SIDE FRAMES: the whole chain over so many frames of a simulated grasp; prints how
// many got a margin. It measures nothing itself: tools/instructions counts what two runs of different length
// execute.
#include <cstdlib>
#include <iostream>
#include <string>

#include "tests/bench/scenes.hpp"

namespace {

constexpr std::size_t kFramesOfGrasp = 200;

int estimate(const std::string& method, std::size_t side, std::size_t frames) {
  using namespace slipd::bench;
  const auto setup = setup_of(side, slipd::method_choices().at(method));
  slipd::EstimatorChain chain(setup, slipd::needs_model(setup) ? model_of(setup) : nullptr);
  Grasp grasp(side, kFramesOfGrasp);
  std::size_t answered = 0;
  for (std::size_t i = 0; i < frames; ++i)
    answered += chain.estimate(grasp.next()).state == slipd::State::ok ? 1 : 0;
  std::cout << answered << '\n';
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 || !slipd::method_choices().contains(argv[1])) {
    std::cerr << "usage: count-estimates METHOD SIDE FRAMES\n";
    return 2;
  }
  return estimate(argv[1], std::stoul(argv[2]), std::stoul(argv[3]));
}
