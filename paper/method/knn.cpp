#include "paper/method/knn.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

constexpr int kMostPlane = 8;        // dimensions
constexpr double kPlaneNear = 0.05;  // of the reach, squared: nearer ones weigh no more
constexpr double kPlaneDamping = 1e-3;

}  // namespace

KnnResult answer_of(Neighbours::Query& query, std::span<const float> point, std::span<const float> gamma,
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

KnnResult plane_answer_of(Neighbours::Query& query, std::span<const float> point,
                          std::span<const float> points, std::span<const float> gamma,
                          std::span<const float> friction) noexcept {
  KnnResult out = answer_of(query, point, gamma, friction);
  const std::size_t rank = point.size();
  if (!out.known || rank > kMostPlane || !(out.reach > 0)) return out;
  // Weighted least squares about the point itself, in units of the furthest neighbour, so that the constant
  // is the answer; the slopes are damped.
  using Square = Eigen::Matrix<double, kMostPlane + 1, kMostPlane + 1>;
  using Vector = Eigen::Matrix<double, kMostPlane + 1, 1>;
  Square normal = Square::Identity() * 1e-9;
  Vector right = Vector::Zero(), row = Vector::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < query.indices().size(); ++i) {
    const std::size_t at = query.indices()[i];
    const double far = std::sqrt(query.squared_distances()[i]) / out.reach;
    const double weight = 1 / (far * far + kPlaneNear);
    row[0] = 1;
    for (std::size_t k = 0; k < rank; ++k) {
      row[static_cast<Eigen::Index>(k) + 1] =
          static_cast<double>(points[at * rank + k] - point[k]) / out.reach;
    }
    normal += weight * row * row.transpose();
    right += weight * gamma[at] * row;
    weights += weight;
  }
  for (Eigen::Index k = 1; k <= static_cast<Eigen::Index>(rank); ++k) normal(k, k) += kPlaneDamping * weights;
  const Vector plane = normal.ldlt().solve(right);
  if (std::isfinite(plane[0])) out.gamma = static_cast<float>(std::clamp(plane[0], 0.0, 1.0));
  return out;
}

}  // namespace slipd
