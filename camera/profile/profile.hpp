// What slipd-camera knows of a kind of sensor: a file of JSON with comments,
// camera/profile/profile.schema.json.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

namespace slipd::camera {

enum class PictureFormat { mjpeg, yuyv, grey };

// What the camera is asked for.
struct PictureWish {
  // Of the camera's pictures, px.
  int width = 0, height = 0;
  PictureFormat format = PictureFormat::mjpeg;
  // Hz
  double rate_hz = 0;
  // 1, 2, 4 or 8: pictures are made smaller by this before anything else.
  int shrink = 1;
  // Of the smaller picture, px; none: all of it.
  std::optional<cv::Rect> crop;
};

struct SurfaceFacts {
  bool texture = false;  // no dots
  bool bright = false;   // dots are brighter than the gel
  // px; 0: found in the first picture.
  double radius_px = 0;
  // From a dot to its nearest neighbour, mm; 0: unknown.
  double pitch_mm = 0;
  // In the picture's middle; 0: by pitch_mm.
  double mm_per_px = 0;
  // Radial distortion; at r from the middle, in halves of the width, a point is really at r (1 + bend r²).
  double bend = 0;
};

struct NodeGrid {
  // Values of a node in a frame: displacement along x and y, change of the picture.
  static constexpr std::uint8_t kValues = 3;
  int rows = 0, columns = 0;
  double pitch_mm = 0;
  std::size_t size() const { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns); }
};

struct Profile {
  PictureWish picture;
  // V4L2 names of the camera's controls, and values.
  std::map<std::string, int> controls;
  SurfaceFacts surface;
  NodeGrid nodes;
};

// `name_or_path`: of a profile in `folder`, without .json, or, with a slash or .json, of a file. Throws
// SettingsError, also for a file that is not there, with the names that are.
Profile load_profile(const std::string& name_or_path, const std::filesystem::path& folder);

}  // namespace slipd::camera
