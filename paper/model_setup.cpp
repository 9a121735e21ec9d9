#include "paper/model_setup.hpp"

#include "core/contact/scene_draws.hpp"
#include "paper/dataset/dataset.hpp"

namespace slipd {
namespace {

// Rings narrower than taxels hold few of them or none. Measured on the contacts of docs/methods.md §26.1: 16
// rings are best from some ten taxels along a contact's radius on, 8 from two.
int rings_for(const ChainSetup& chain) {
  if (chain.scene.objects.empty()) return Rings::kCount;
  const double taxels = mean_contact_radius_m(chain.scene) / chain.layout.side_m();
  if (taxels > 10) return 16;
  return taxels > 2 ? 8 : 4;
}

}  // namespace

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
          .view = rings ? View::rings : View::grid,
          .rings = rings ? rings_for(chain) : static_cast<int>(Rings::kCount)};
}

}  // namespace slipd
