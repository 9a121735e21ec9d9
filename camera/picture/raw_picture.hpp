// Bytes of a camera's buffer → brightness. Any one thread.
#pragma once

#include <cstddef>
#include <span>

#include "camera/picture/jpeg.hpp"
#include "camera/profile/profile.hpp"

namespace slipd::camera {

// `bytes`: a picture of wish.width x wish.height in wish.format; rows of `stride` bytes, which MJPEG does not
// have. The result is made smaller by wish.shrink. Too few bytes, or a JPEG of another size: torn and empty.
Decoded decode(std::span<const std::byte> bytes, const PictureWish& wish, std::size_t stride);

// The same picture, smaller by `shrink` along both sides: means of its pixels.
cv::Mat shrunk(const cv::Mat& picture, int shrink);

}  // namespace slipd::camera
