// How much the picture has changed around each node since rest. One thread's own.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace slipd::camera {

class PictureChange {
 public:
  // The picture at rest, CV_8UC1.
  void rest(const cv::Mat& picture) { rest_ = picture.clone(); }
  // Mean absolute difference to rest in a square of `side_px` around each node, 0 … 1 of full brightness, of
  // the part of the square that is in the picture; 0 if none is. A change that most of the picture has in
  // common is the light's, and left out.
  std::vector<float> at(const cv::Mat& picture, std::span<const cv::Point2f> nodes, double side_px);

 private:
  cv::Mat rest_, difference_;
};

}  // namespace slipd::camera
