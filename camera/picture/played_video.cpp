#include "camera/picture/played_video.hpp"

#include <thread>

namespace slipd::camera {

using std::chrono::steady_clock;  // CLOCK_MONOTONIC, ns

PlayedVideo::PlayedVideo(const std::string& path, int shrink)
    : video_(path, shrink), begun_(steady_clock::now()) {}

std::optional<Picture> PlayedVideo::next() {
  const std::chrono::duration<double> since(static_cast<double>(taken_) / rate_hz());
  const auto due = begun_ + std::chrono::duration_cast<steady_clock::duration>(since);
  std::this_thread::sleep_until(due);
  auto picture = video_.next();
  if (!picture) return std::nullopt;
  ++taken_;
  picture->time_ns = std::chrono::nanoseconds(due.time_since_epoch()).count();
  return picture;
}

}  // namespace slipd::camera
