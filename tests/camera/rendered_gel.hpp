// Renders pictures of a gel with dots, whose displacement is known everywhere: the truth for slipd-camera.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace slipd::testing {

struct RenderedGel {
  int width = 320, height = 240;  // px
  double spacing = 20;            // of dots, px
  double radius = 2.5;            // of a dot, px
  double gel = 150, dot = 40;     // brightness, 0 … 255
  double shade = 30;              // how much darker the right edge is than the left
  double noise = 1.5;             // of each pixel, standard deviation
  double missing = 0;             // share of dots that are not there
  std::uint32_t seed = 1;         // of the missing dots
};

// Displacement of the surface that rests at a place, px.
using Displacement = std::function<cv::Point2f(cv::Point2f rest)>;

// Where dots rest that are there.
std::vector<cv::Point2f> resting_dots(const RenderedGel& gel);
// The picture, CV_8UC1; `picture` seeds its noise. Each pixel is the mean of 8 x 8 points.
cv::Mat rendered(const RenderedGel& gel, const Displacement& moved, std::uint32_t picture);
// A press as large as a third of the picture that drags the surface along by at most (x, y) px and spreads it
// by `spread` px.
Displacement press(const RenderedGel& gel, float x, float y, float spread);

// Writes a video without loss. Throws std::runtime_error.
void write_video(const std::string& path, const std::vector<cv::Mat>& pictures, double rate_hz);

}  // namespace slipd::testing
