// Points on a taxel's side and their weights, by which a SubsurfaceSheet averages over the taxel's square.
#pragma once

#include <vector>

namespace slipd::contact {

struct SideRule {
  std::vector<double> at, weight;  // from the middle, m; the weights' sum is 1
};

// Gauss-Legendre, with as many points as keep averages under a skin within 1e-4 of a dome's height: more at
// smaller depths. At depth 0 the points are lines, each of them exact.
SideRule exact_side_rule(double side_m, double depth_m);
// The same within about 1e-2.
SideRule rough_side_rule(double side_m, double depth_m);

}  // namespace slipd::contact
