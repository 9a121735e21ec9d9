// What a rectangle under a skin reads in all of a point load on the surface (docs/theory.md §5.6). Over the
// whole plane it is the load; a pad reads less, of a pull much less: what a pull makes a point at distance r
// read falls with the third power of r.
#pragma once

#include <span>

#include "core/contact/subsurface/rigid_base.hpp"
#include "core/contact/subsurface/subsurface_point.hpp"

namespace slipd::contact {

// Of a plane at the taxels' depth, in m from the load; left < right, bottom < top.
struct Rectangle {
  double left_m = 0, right_m = 0, bottom_m = 0, top_m = 0;
};

// Forces on the rectangle, in a half space, over the load's: normal force and shear, by a normal load and by
// a pull, along the sensor's axes. Exact. depth_m > 0.
SensedTensor sensed_in_rectangle(const Rectangle& rectangle, double depth_m) noexcept;

// The same of a skin with these images; none: a half space.
LayerTensor sensed_in_rectangle(const Rectangle& rectangle, double depth_m,
                                std::span<const LayerImage> images) noexcept;

}  // namespace slipd::contact
