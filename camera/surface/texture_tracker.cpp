#include "camera/surface/texture_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/video/tracking.hpp>

namespace slipd::camera {
namespace {

// Levels above the picture itself: a step of a patch's size is followed on the second.
constexpr int kLevels = 2;
constexpr int kMostSteps = 20;
// Steps smaller than this end the search, px.
constexpr double kFine = 0.01;
// Least eigenvalue of a patch's gradients, as OpenCV counts it: below, the patch has no texture.
constexpr double kLeastTexture = 1e-4;

}  // namespace

bool TextureTracker::rest(const cv::Mat& picture) {
  spacing_ = static_cast<double>(std::max(picture.cols, picture.rows)) / options_.patches;
  const int side = std::max(5, static_cast<int>(std::lround(options_.side * spacing_)) | 1);
  window_ = {side, side};
  cv::buildOpticalFlowPyramid(picture, rest_, window_, kLevels);
  rest_places_.clear();
  points_.clear();
  for (int row = 0; (row + 0.5) * spacing_ < picture.rows; ++row) {
    for (int column = 0; (column + 0.5) * spacing_ < picture.cols; ++column) {
      rest_places_.emplace_back(static_cast<float>((column + 0.5) * spacing_),
                                static_cast<float>((row + 0.5) * spacing_));
      points_.push_back({rest_places_.back(), rest_places_.back(), false});
    }
  }
  now_places_ = rest_places_;
  return true;
}

const std::vector<SurfacePoint>& TextureTracker::follow(const cv::Mat& picture) {
  cv::buildOpticalFlowPyramid(picture, now_, window_, kLevels);
  std::vector<std::uint8_t> found;
  std::vector<float> differences;
  for (std::size_t i = 0; i < points_.size(); ++i) now_places_[i] = points_[i].now;
  cv::calcOpticalFlowPyrLK(
      rest_, now_, rest_places_, now_places_, found, differences, window_, kLevels,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kMostSteps, kFine),
      cv::OPTFLOW_USE_INITIAL_FLOW, kLeastTexture);
  const cv::Rect2f inside({}, cv::Size2f(picture.size()));
  for (std::size_t i = 0; i < points_.size(); ++i) {
    points_[i].seen =
        found[i] != 0 && differences[i] < options_.most_difference && inside.contains(now_places_[i]);
    if (points_[i].seen) points_[i].now = now_places_[i];
  }
  return points_;
}

}  // namespace slipd::camera
