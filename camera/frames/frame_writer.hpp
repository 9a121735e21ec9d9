// Frames as the messages of push_layout, one after the other, to a file or a pipe: what slipd's socket would
// get. One thread's own.
#pragma once

#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "camera/picture/picture.hpp"
#include "camera/profile/profile.hpp"

namespace slipd::camera {

class FrameWriter {
 public:
  // Writes the hello. `path`: "-" is standard output. Throws std::system_error.
  FrameWriter(const std::string& path, const NodeGrid& nodes, double rate_hz);

  // Values of a frame, or none: then the frame is marked as bad and has no number. Throws std::system_error.
  void write(const Picture& picture, std::span<const float> values);

 private:
  struct Close {
    void operator()(std::FILE* file) const noexcept {
      if (file != stdout) std::fclose(file);
    }
  };
  void put(const void* bytes, std::size_t size);

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<float> none_;
};

}  // namespace slipd::camera
