// A point of the gel's surface that is followed from picture to picture: a dot, or a patch of texture.
#pragma once

#include <opencv2/core/types.hpp>

namespace slipd::camera {

struct SurfacePoint {
  // Where it is at rest, pixels from the middle of the picture's first pixel, x right, y down.
  cv::Point2f rest;
  // Where it is now; where it is expected while it is not seen.
  cv::Point2f now;
  // Whether it is seen in this picture.
  bool seen = false;
};

}  // namespace slipd::camera
