#include "camera/picture/played_video.hpp"

#include <thread>

namespace slipd::camera {

using std::chrono::steady_clock;  // CLOCK_MONOTONIC, ns

PlayedVideo::PlayedVideo(const std::string& path, int shrink)
    : video_(path, shrink), due_(steady_clock::now()) {}

std::optional<Picture> PlayedVideo::next() {
  std::this_thread::sleep_until(due_);
  auto picture = video_.next();
  if (!picture) return std::nullopt;
  picture->time_ns = std::chrono::nanoseconds(due_.time_since_epoch()).count();
  due_ += std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(1 / rate_hz()));
  return picture;
}

}  // namespace slipd::camera
