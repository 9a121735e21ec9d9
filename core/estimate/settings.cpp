#include "core/estimate/settings.hpp"

namespace slipd {

const std::map<std::string, MethodChoice>& method_choices() {
  static const std::map<std::string, MethodChoice> kChoices{{"auto", MethodChoice::automatic},
                                                            {"svd-knn", MethodChoice::svd_knn},
                                                            {"registered", MethodChoice::registered},
                                                            {"moments", MethodChoice::moments},
                                                            {"fit", MethodChoice::fit},
                                                            {"closing", MethodChoice::closing},
                                                            {"block-fit", MethodChoice::block_fit}};
  return kChoices;
}

}  // namespace slipd
