#include "camera/surface/picture_change.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace slipd::camera {
namespace {

constexpr int kFull = 255;  // brightness
// Every so many-th pixel of every so many-th row says how the light has changed.
constexpr int kStride = 4;

// Median of the difference over the picture: a contact covers less than half of it, the light all.
int change_of_light(const cv::Mat& difference) {
  std::array<int, 2 * kFull + 1> count{};
  int total = 0;
  for (int y = 0; y < difference.rows; y += kStride) {
    const auto* row = difference.ptr<std::int16_t>(y);
    for (int x = 0; x < difference.cols; x += kStride, ++total) {
      const int level = row[x] + kFull;
      ++count[static_cast<std::size_t>(level)];
    }
  }
  int below = 0;
  for (int i = 0; i < static_cast<int>(count.size()); ++i) {
    below += count[static_cast<std::size_t>(i)];
    if (2 * below >= total) return i - kFull;
  }
  return 0;
}

}  // namespace

std::vector<float> PictureChange::at(const cv::Mat& picture, std::span<const cv::Point2f> nodes,
                                     double side_px) {
  cv::subtract(picture, rest_, difference_, cv::noArray(), CV_16S);
  const int light = change_of_light(difference_);
  const auto half = static_cast<float>(side_px / 2);
  std::vector<float> out;
  out.reserve(nodes.size());
  for (const cv::Point2f& node : nodes) {
    const int left = std::max(0, static_cast<int>(std::ceil(node.x - half)));
    const int right = std::min(picture.cols, static_cast<int>(std::floor(node.x + half)) + 1);
    const int top = std::max(0, static_cast<int>(std::ceil(node.y - half)));
    const int bottom = std::min(picture.rows, static_cast<int>(std::floor(node.y + half)) + 1);
    std::int64_t sum = 0;
    for (int y = top; y < bottom; ++y) {
      const auto* row = difference_.ptr<std::int16_t>(y);
      int of_row = 0;
      for (int x = left; x < right; ++x) of_row += std::abs(row[x] - light);
      sum += of_row;
    }
    const double pixels = static_cast<double>(std::max(0, right - left)) * std::max(0, bottom - top);
    out.push_back(pixels > 0 ? static_cast<float>(static_cast<double>(sum) / (pixels * kFull)) : 0.0F);
  }
  return out;
}

}  // namespace slipd::camera
