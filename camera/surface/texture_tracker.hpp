// Follows patches of the gel's texture on a grid, where there are no dots: each is sought in the picture at
// rest and now by the pyramids of Lucas and Kanade (Bouguet, "Pyramidal implementation of the affine Lucas
// Kanade feature tracker", Intel, 2001; OpenCV's). It begins where the patch was last, so nothing drifts. One
// thread's own.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "camera/surface/surface_tracker.hpp"

namespace slipd::camera {

struct TextureTrackerOptions {
  // Patches along the longer side of the picture; 5 … 60. Too small: a coarse field. Too large: time.
  int patches = 16;
  // Side of a patch; of the distance between patches, 0.5 … 3. Too small: the texture is ambiguous. Too
  // large: a patch shows its surroundings.
  double side = 1.2;
  // Largest mean difference between a patch at rest and now; of 255, 5 … 60. Too small: light that changes
  // hides the surface. Too large: anything matches.
  float most_difference = 24;
};

class TextureTracker final : public SurfaceTracker {
 public:
  explicit TextureTracker(TextureTrackerOptions options = {}) : options_(options) {}

  bool rest(const cv::Mat& picture) override;
  const std::vector<SurfacePoint>& follow(const cv::Mat& picture) override;
  double spacing_px() const override { return spacing_; }
  double radius_px() const override { return options_.side * spacing_ / 2; }

 private:
  TextureTrackerOptions options_;
  double spacing_ = 0;
  cv::Size window_;                  // of a patch, px
  std::vector<cv::Mat> rest_, now_;  // pyramids
  std::vector<cv::Point2f> rest_places_, now_places_;
  std::vector<SurfacePoint> points_;
};

}  // namespace slipd::camera
