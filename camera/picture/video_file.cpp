#include "camera/picture/video_file.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "camera/picture/raw_picture.hpp"

namespace slipd::camera {
namespace {

constexpr double kNsPerSecond = 1e9;
// Hz, of a file that does not say its rate.
constexpr double kUsualRate = 25;

}  // namespace

VideoFile::VideoFile(const std::string& path, int shrink) : shrink_(shrink) {
  if (!video_.open(path, cv::CAP_FFMPEG))
    throw std::runtime_error(path + ": no video that FFmpeg can read; check the path, and `ffprobe` it");
  rate_hz_ = video_.get(cv::CAP_PROP_FPS);
  if (!(rate_hz_ > 0)) rate_hz_ = kUsualRate;
}

std::optional<Picture> VideoFile::next() {
  if (!video_.grab()) return std::nullopt;
  ++taken_;
  Picture picture;
  picture.sequence = taken_;
  picture.time_ns = std::llround(static_cast<double>(taken_) / rate_hz_ * kNsPerSecond);
  if (!video_.retrieve(colours_)) return picture;
  if (colours_.channels() == 1) {
    picture.brightness = std::exchange(colours_, {});
  } else {
    cv::cvtColor(colours_, picture.brightness, cv::COLOR_BGR2GRAY);
  }
  picture.brightness = shrunk(picture.brightness, shrink_);
  return picture;
}

}  // namespace slipd::camera
