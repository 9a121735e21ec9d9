// Pictures of a gel → frames for slipd: at each node of the profile's grid the displacement of the surface in
// mm and the change of the picture. One thread's own.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "camera/picture/picture.hpp"
#include "camera/profile/profile.hpp"
#include "camera/surface/picture_change.hpp"
#include "camera/surface/surface_tracker.hpp"

namespace slipd::camera {

struct GelReaderOptions {
  // Least mean brightness of a picture that is used; of 255, 1 … 60. Too small: dots are sought in the dark.
  // Too large: a dim lamp stops the sensor. Chosen: twice the black of a camera with video range (16).
  double least_brightness = 32;
  // Pictures that are equal to the last bit before they count as frozen; 2 … 1000. Too small: a film's
  // repeated pictures are a fault. Too large: a camera that hangs looks like a still gel. A camera's noise
  // changes each picture.
  int most_repeats = 12;
};

class GelReader {
 public:
  explicit GelReader(Profile profile, GelReaderOptions options = {});

  // Takes the next usable picture as rest.
  void rest_anew() noexcept { resting_ = false; }
  // The frame of a picture: for each node x, y in mm, and change, by rows from the picture's top; empty: the
  // picture cannot be used. The first usable picture is rest. Throws std::runtime_error if the picture's size
  // does not fit the profile.
  std::span<const float> read(const Picture& picture);

  // What was last read, for a view. May be empty.
  const std::vector<SurfacePoint>& points() const noexcept { return points_; }
  // The part of the picture that is looked at.
  const cv::Mat& gel() const noexcept { return gel_; }
  const std::vector<cv::Point2f>& nodes_px() const noexcept { return nodes_px_; }
  double radius_px() const { return tracker_->radius_px(); }
  double spacing_px() const { return tracker_->spacing_px(); }
  double mm_per_px() const noexcept { return mm_per_px_; }

 private:
  bool usable(const Picture& picture);
  bool take_rest();
  void place_nodes();
  cv::Point2f unbent(cv::Point2f at) const;
  std::vector<SurfacePoint> unbent(const std::vector<SurfacePoint>& points) const;

  Profile profile_;
  GelReaderOptions options_;
  std::unique_ptr<SurfaceTracker> tracker_;
  PictureChange change_;
  bool resting_ = false;
  int repeats_ = 0;
  double mm_per_px_ = 0;
  cv::Mat gel_, last_;
  std::vector<cv::Point2f> nodes_px_;
  std::vector<SurfacePoint> points_;
  std::vector<float> values_;
};

}  // namespace slipd::camera
