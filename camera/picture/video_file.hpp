// Pictures of a video file, each once and as fast as they are asked for. One thread's own.
#pragma once

#include <opencv2/videoio.hpp>
#include <optional>
#include <string>

#include "camera/picture/picture.hpp"

namespace slipd::camera {

class VideoFile {
 public:
  // Throws std::runtime_error for a file that is missing, or that FFmpeg cannot read.
  explicit VideoFile(const std::string& path);

  // The file's nominal rate, Hz, above 0.
  double rate_hz() const noexcept { return rate_hz_; }
  // The next picture; none at the end. Picture n, counted from 1, has the time n / rate_hz. A picture that
  // cannot be decoded is empty.
  std::optional<Picture> next();

 private:
  cv::VideoCapture video_;
  double rate_hz_ = 0;
  std::uint64_t taken_ = 0;
  cv::Mat colours_;
};

}  // namespace slipd::camera
