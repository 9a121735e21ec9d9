// A picture of a camera, as brightness. Plain values; one thread at a time.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace slipd::camera {

struct Picture {
  // Brightness of each pixel, CV_8UC1, rows from the top. Empty: the picture could not be decoded.
  cv::Mat brightness;
  // Of the exposure, CLOCK_MONOTONIC; of a file, since its beginning by its nominal rate. ns
  std::int64_t time_ns = 0;
  // Rises by 1 with each picture of the camera; a jump means lost pictures.
  std::uint64_t sequence = 0;
  // The decoder complained: a part of the picture is missing or garbled.
  bool torn = false;
};

}  // namespace slipd::camera
