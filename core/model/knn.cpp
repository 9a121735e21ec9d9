#include "core/model/knn.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

KnnAnswer answer_of(Neighbours::Query& query, std::span<const float> point, std::span<const float> gamma,
                    std::span<const float> friction) noexcept {
  const std::size_t found = query.find(point);
  if (found == 0) return {};
  constexpr float kSamePoint = 1e-6F;  // rad; closer than that the neighbour is the answer
  float weights = 0, sum = 0, squares = 0, frictions = 0;
  for (std::size_t i = 0; i < found; ++i) {
    const std::size_t at = query.indices()[i];
    const float weight = 1 / (std::sqrt(query.squared_distances()[i]) + kSamePoint);
    weights += weight;
    sum += weight * gamma[at];
    squares += weight * gamma[at] * gamma[at];
    frictions += weight * friction[at];
  }
  const float mean = sum / weights;
  return {.known = true,
          .gamma = std::clamp(mean, 0.0F, 1.0F),
          .friction = frictions / weights,
          .spread = std::sqrt(std::max(0.0F, squares / weights - mean * mean)),
          .distance = std::sqrt(query.squared_distances()[0]),
          .reach = std::sqrt(query.squared_distances()[found - 1])};
}

}  // namespace slipd
