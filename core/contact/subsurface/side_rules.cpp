#include "core/contact/subsurface/side_rules.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <cstddef>

namespace slipd::contact {
namespace {

template <unsigned kPoints>
SideRule gauss(double side_m) {
  using Rule = boost::math::quadrature::gauss<double, kPoints>;  // nodes that are not negative, on -1 … 1
  const auto& node = Rule::abscissa();
  const auto& share = Rule::weights();
  SideRule rule;
  for (std::size_t i = 0; i < node.size(); ++i) {
    for (const double sign : {-1.0, 1.0}) {
      if (node[i] == 0 && sign > 0) continue;
      rule.at.push_back(sign * node[i] * side_m / 2);
      rule.weight.push_back(share[i] / 2);
    }
  }
  return rule;
}

}  // namespace

SideRule exact_side_rule(double side_m, double depth_m) {
  if (!(depth_m > 0)) return gauss<20>(side_m);
  const double ratio = side_m / depth_m;
  if (ratio <= 0.55) return gauss<2>(side_m);
  if (ratio <= 1.5) return gauss<3>(side_m);
  if (ratio <= 2.2) return gauss<4>(side_m);
  if (ratio <= 4.2) return gauss<8>(side_m);
  if (ratio <= 8.5) return gauss<10>(side_m);
  return gauss<20>(side_m);
}

SideRule rough_side_rule(double side_m, double depth_m) {
  if (!(depth_m > 0)) return gauss<4>(side_m);
  const double ratio = side_m / depth_m;
  if (ratio <= 0.55) return {{0.0}, {1.0}};
  if (ratio <= 2.2) return gauss<2>(side_m);
  if (ratio <= 4.2) return gauss<3>(side_m);
  return gauss<4>(side_m);
}

}  // namespace slipd::contact
