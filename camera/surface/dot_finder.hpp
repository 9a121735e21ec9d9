// Finds dark dots (or bright ones) on a gel in one picture, without knowing where they are: a dot is darker
// than its surroundings, by a share that the picture itself tells. The middle of a dot is its centroid of
// darkness. One thread's own.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace slipd::camera {

struct DotFinderOptions {
  // Radius of a dot; px, 1.5 … 100; 0: found in the picture. Too small: specks of a dot or of the gel are
  // dots. Too large: neighbours melt together.
  double radius_px = 0;
  // Whether dots are brighter than the gel instead of darker.
  bool bright = false;
  // Least contrast of a dot against its surroundings; a share, 0.02 … 0.5. Too small: noise is dots in a
  // picture without dots. Too large: faint dots are lost. Chosen: four times the contrast of a camera's noise
  // of 2 %.
  double least_contrast = 0.08;
  // A dot has at least this share of the usual contrast; 0.2 … 0.8. Too small: relief of an object is dots.
  // Too large: dots in shadow are lost. Chosen: the middle between no dot and a usual one.
  double share_of_usual = 0.5;
};

struct Dot {
  // Centroid, px.
  cv::Point2f place;
  // Contrast against the surroundings, a share of their brightness.
  float contrast = 0;
};

class DotFinder {
 public:
  explicit DotFinder(const DotFinderOptions& options) : options_(options), radius_(options.radius_px) {}

  // Learns radius and usual contrast from this picture, CV_8UC1.
  void learn(const cv::Mat& picture);
  // The dots of a picture, strongest first; learns first if nothing was learned. The usual contrast follows
  // the picture's.
  const std::vector<Dot>& find(const cv::Mat& picture);
  // px; 0 before the first picture.
  double radius_px() const noexcept { return radius_; }

 private:
  void contrast_of(const cv::Mat& picture, double radius);
  void peaks_above(float least, double radius);
  void to_centroid(const cv::Mat& picture, Dot& dot) const;
  float split_of_peaks() const;

  DotFinderOptions options_;
  double radius_;
  float usual_contrast_ = 0;
  cv::Mat small_, large_, contrast_, highest_;
  std::vector<Dot> dots_;
};

}  // namespace slipd::camera
