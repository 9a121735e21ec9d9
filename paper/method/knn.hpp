// From a point's neighbours to an answer (docs/methods.md §26.4): the same in training, where its errors are
// measured, and in use. Any thread.
#pragma once

#include <algorithm>
#include <span>

#include "paper/model/model.hpp"

namespace slipd {

struct KnnResult {
  bool known = false;  // false: the point was not finite
  float gamma = 0;     // mean of the neighbours', weighted by 1/distance
  float friction = 0;  // likewise
  float spread = 0;    // standard deviation of the neighbours' gammas, same weights
  float distance = 0;  // to the nearest, rad
  float reach = 0;     // to the furthest of them, rad
};

// `gamma` and `friction`: of the points that `query` searches.
KnnResult answer_of(Neighbours::Query& query, std::span<const float> point, std::span<const float> gamma,
                    std::span<const float> friction) noexcept;

// How many a model's answers are made of: k, and on rings at least as many as a plane is well laid through.
constexpr std::size_t searched(const ModelSetup& setup) noexcept {
  constexpr int kPlane = 16;
  return static_cast<std::size_t>(setup.view == View::rings ? std::max(setup.neighbours, kPlane)
                                                            : setup.neighbours);
}

// The same with the neighbours' slope taken out: a plane through their gammas instead of their mean, held
// flat where they do not tell its slope. `points`: as the query searches them, one after the other. For
// smooth families of few dimensions, as contacts on rings are.
KnnResult plane_answer_of(Neighbours::Query& query, std::span<const float> point,
                          std::span<const float> points, std::span<const float> gamma,
                          std::span<const float> friction) noexcept;

// Share of |alpha|² that the basis does not hold, 0 … 1; 0 without any alpha.
constexpr float residual_share(float alpha_squared, float projection_squared) noexcept {
  return alpha_squared > 0 ? std::max(0.0F, 1 - projection_squared / alpha_squared) : 0.0F;
}

}  // namespace slipd
