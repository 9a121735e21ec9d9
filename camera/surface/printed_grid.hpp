// Where dots that were printed as a regular grid are at rest, found in a picture in which something may touch
// the gel: the even grid that is nearest to all of them. Any one thread.
#pragma once

#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

namespace slipd::camera {

// The place of each dot on the grid, px; empty: the dots make no grid, less than four fifths of them are in
// rows and columns. `spacing_px`: of neighbours, above 0. A dot off the grid stays in its place.
std::vector<cv::Point2f> on_printed_grid(std::span<const cv::Point2f> dots, double spacing_px);

}  // namespace slipd::camera
