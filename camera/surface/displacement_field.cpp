#include "camera/surface/displacement_field.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace slipd::camera {
namespace {

constexpr int kTerms = 6;  // 1, x, y, xx, xy, yy
using Terms = Eigen::Matrix<double, kTerms, 1>;
// Weights of prior values 0 of slope and curvature, in points: what too few points cannot tell is flat.
constexpr double kFlat = 0.02;
constexpr double kStraight = 0.05;
// Points further away than this many widths count nothing.
constexpr double kCutOff = 3;

cv::Point2f fit(cv::Point2f node, std::span<const SurfacePoint> points, double spacing,
                const DisplacementFieldOptions& options) {
  Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, 2> right = Eigen::Matrix<double, kTerms, 2>::Zero();
  bool near = false;
  for (const SurfacePoint& point : points) {
    if (!point.seen) continue;
    const double x = (point.rest.x - node.x) / spacing, y = (point.rest.y - node.y) / spacing;
    const double square = x * x + y * y;
    if (square > kCutOff * kCutOff * options.width * options.width) continue;
    near = near || square < options.reach * options.reach;
    const double weight = std::exp(-square / (2 * options.width * options.width));
    const Terms terms{1, x, y, x * x, x * y, y * y};
    const cv::Point2f moved = point.now - point.rest;
    normal.noalias() += weight * terms * terms.transpose();
    right.noalias() += weight * terms * Eigen::RowVector2d(moved.x, moved.y);
  }
  if (!near) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    return {kNone, kNone};
  }
  normal.diagonal() += Terms{0, kFlat, kFlat, kStraight, kStraight, kStraight};
  const Eigen::RowVector2d at_node = normal.ldlt().solve(right).row(0);
  return {static_cast<float>(at_node.x()), static_cast<float>(at_node.y())};
}

}  // namespace

std::vector<cv::Point2f> displacement_at(std::span<const cv::Point2f> nodes,
                                         std::span<const SurfacePoint> points, double spacing_px,
                                         const DisplacementFieldOptions& options) {
  std::vector<cv::Point2f> out;
  out.reserve(nodes.size());
  for (const cv::Point2f& node : nodes) out.push_back(fit(node, points, spacing_px, options));
  return out;
}

}  // namespace slipd::camera
