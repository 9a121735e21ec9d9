#include "core/contact/scene.hpp"

namespace slipd {

std::vector<ObjectFamily> paper_objects() {
  const ObjectFamily stiff;
  ObjectFamily soft;
  soft.modulus_pa = {0.1e6, 10e6};
  soft.poisson = {0.35, 0.45};
  return {stiff, soft};
}

}  // namespace slipd
