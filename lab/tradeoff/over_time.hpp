// Sensors whose single frames do not determine the margin, over a grasp: before and after its first slip.
#pragma once

#include <vector>

#include "lab/tradeoff/measure.hpp"

namespace lab {

// Each grasp is closed, loaded until it slides, and then unloaded, loaded and regripped at random.
std::vector<Line> measure_over_time(const std::string& layout, const slipd::TaxelLayout& taxels,
                                    const slipd::Scene& scene, const Noise& noise, std::size_t grasps,
                                    std::uint64_t seed);

}  // namespace lab
