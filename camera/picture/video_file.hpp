// Pictures of a video file, each once and as fast as they are asked for. One thread's own.
#pragma once

#include <opencv2/videoio.hpp>
#include <optional>
#include <string>

#include "camera/picture/picture_source.hpp"

namespace slipd::camera {

class VideoFile final : public PictureSource {
 public:
  // `shrink`: pictures are made smaller by this. Throws std::runtime_error for a file that is missing, or
  // that FFmpeg cannot read.
  VideoFile(const std::string& path, int shrink);

  // The file's nominal rate, Hz, above 0.
  double rate_hz() const noexcept override { return rate_hz_; }
  // The next picture; none at the end. Picture n, counted from 1, has the time n / rate_hz. A picture that
  // cannot be decoded is empty.
  std::optional<Picture> next() override;

 private:
  cv::VideoCapture video_;
  int shrink_;
  double rate_hz_ = 0;
  std::uint64_t taken_ = 0;
  cv::Mat colours_;
};

}  // namespace slipd::camera
