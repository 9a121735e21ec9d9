// A video file in place of a camera: each picture comes when a camera would have sent it. One thread's own.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "camera/picture/video_file.hpp"

namespace slipd::camera {

class PlayedVideo final : public PictureSource {
 public:
  // Plays from now on. Parameters and errors as of VideoFile.
  PlayedVideo(const std::string& path, int shrink);

  // Waits until the next picture is due, and decodes it then. Its time is when it was due, of
  // CLOCK_MONOTONIC, ns. None at the end.
  std::optional<Picture> next() override;
  double rate_hz() const noexcept override { return video_.rate_hz(); }

 private:
  VideoFile video_;
  std::chrono::steady_clock::time_point due_;  // of the next picture
};

}  // namespace slipd::camera
