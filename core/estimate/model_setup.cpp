#include "core/estimate/model_setup.hpp"

#include "core/contact/hertz.hpp"
#include "core/model/dataset.hpp"

namespace slipd {
namespace {

// Rings narrower than taxels hold few of them or none. Measured on the contacts of docs/theory.md §9.1: 16
// rings are best from some ten taxels along a contact's radius on, 8 from two.
int rings_for(const ChainSetup& chain) {
  constexpr std::size_t kDraws = 32;
  if (chain.scene.objects.empty()) return Rings::kCount;
  double radius_m = 0;
  for (std::size_t i = 0; i < kDraws; ++i) {
    const ContactDraw draw = draw_contact(chain.scene, 1, i);
    const auto pair = contact::make_body_pair(contact::body_of(chain.scene.skin),
                                              {draw.radius_m, draw.modulus_pa, draw.poisson});
    radius_m += pair.contact_radius_m(draw.normal_n) / kDraws;
  }
  const double taxels = radius_m / chain.layout.side_m();
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
