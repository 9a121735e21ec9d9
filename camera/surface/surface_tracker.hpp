// Follows the gel's surface from picture to picture, by its dots or by its texture. One thread's own.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "camera/profile/profile.hpp"
#include "camera/surface/surface_point.hpp"

namespace slipd::camera {

class SurfaceTracker {
 public:
  virtual ~SurfaceTracker() = default;
  // This picture, CV_8UC1, shows the surface at rest. False: there is nothing to follow in it.
  virtual bool rest(const cv::Mat& picture) = 0;
  // Where the points are in the next picture, of the same size. After rest().
  virtual const std::vector<SurfacePoint>& follow(const cv::Mat& picture) = 0;
  // Usual distance between neighbours at rest, px. After rest(), above 0.
  virtual double spacing_px() const = 0;
  // Radius of what is followed, px. After rest().
  virtual double radius_px() const = 0;
};

std::unique_ptr<SurfaceTracker> make_tracker(const SurfaceFacts& facts);

}  // namespace slipd::camera
