#include "lab/estimator.hpp"

#include <utility>

#include "paper/model_setup.hpp"
#include "paper/train.hpp"

namespace lab {

using namespace slipd;

std::string title_of(std::size_t side, const std::string& method) {
  return std::to_string(side) + "x" + std::to_string(side) + " " + method;
}

ChainSetup paper_chain(std::size_t side, MethodChoice method, double noise) {
  const double pitch_m = side == 4 ? 0.0047 : 0.016 / static_cast<double>(side);
  ChainSetup chain{.layout = TaxelLayout::grid(side, side, pitch_m),
                   .scene = {},
                   .estimator = {.method = method},
                   .alerts = {},
                   .friction = {}};
  chain.scene.objects = paper_objects();
  chain.scene.offset_m = 0.002;
  chain.scene.noise = noise;
  return chain;
}

Estimator make_estimator(ChainSetup setup, unsigned threads) {
  Estimator made{.setup = std::move(setup), .model = nullptr};
  if (needs_model(made.setup))
    made.model = std::make_shared<const Model>(train(model_setup_of(made.setup), threads));
  return made;
}

}  // namespace lab
