// Decodes the brightness of a JPEG picture by libjpeg-turbo, made smaller in the same step. One thread's own.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>

namespace slipd::camera {

struct Decoded {
  // CV_8UC1; empty: this is no JPEG picture.
  cv::Mat brightness;
  // The decoder found garbled or missing data.
  bool torn = false;
};

// `shrink`: 1, 2, 4 or 8. Pictures larger than 8192 x 8192 are refused.
Decoded decode_jpeg(std::span<const std::byte> bytes, int shrink);

}  // namespace slipd::camera
