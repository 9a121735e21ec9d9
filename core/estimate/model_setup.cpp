#include "core/estimate/model_setup.hpp"

namespace slipd {

ModelSetup model_setup_of(const ChainSetup& chain) {
  return {.layout = chain.layout,
          .scene = chain.scene,
          .size = kUnseenFirst,
          .seed = 1,
          .rank = chain.estimator.rank,
          .neighbours = chain.estimator.neighbours};
}

}  // namespace slipd
