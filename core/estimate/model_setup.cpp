#include "core/estimate/model_setup.hpp"

namespace slipd {

ModelSetup model_setup_of(const ChainSetup& chain) {
  // On rings only friction and margin are left, which are to be covered densely in both; on the grid every
  // contact is another picture.
  const bool rings = chain.estimator.method == MethodChoice::registered;
  return {.layout = chain.layout,
          .scene = chain.scene,
          .size = rings ? DataSetSize{} : kUnseenFirst,
          .seed = 1,
          .rank = chain.estimator.rank,
          .neighbours = chain.estimator.neighbours,
          .view = rings ? View::rings : View::grid};
}

}  // namespace slipd
