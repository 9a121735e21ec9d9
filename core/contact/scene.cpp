#include "core/contact/scene.hpp"

namespace slipd {

std::vector<ObjectFamily> paper_objects() {
  const ObjectFamily stiff;
  ObjectFamily soft;
  soft.modulus_pa = {0.1e6, 10e6};
  soft.poisson = {0.35, 0.45};
  return {stiff, soft};
}

Range expected_friction(const Scene& scene) {
  Range all{0.1, 0.9};
  if (!scene.objects.empty()) all = scene.objects.front().friction;
  for (const auto& family : scene.objects) {
    all = {std::min(all.low, family.friction.low), std::max(all.high, family.friction.high)};
  }
  return all;
}

}  // namespace slipd
