#include "camera/picture/raw_picture.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace slipd::camera {
namespace {

Decoded decode_mjpeg(std::span<const std::byte> bytes, const PictureWish& wish) {
  Decoded out = decode_jpeg(bytes, wish.shrink);
  const auto side = [&](int full) { return (full + wish.shrink - 1) / wish.shrink; };
  if (out.brightness.size() != cv::Size(side(wish.width), side(wish.height))) return {{}, true};
  return out;
}

}  // namespace

cv::Mat shrunk(const cv::Mat& picture, int shrink) {
  if (shrink == 1) return picture;
  cv::Mat out;
  cv::resize(picture, out, {picture.cols / shrink, picture.rows / shrink}, 0, 0, cv::INTER_AREA);
  return out;
}

Decoded decode(std::span<const std::byte> bytes, const PictureWish& wish, std::size_t stride) {
  if (wish.format == PictureFormat::mjpeg) return decode_mjpeg(bytes, wish);
  const bool yuyv = wish.format == PictureFormat::yuyv;
  const std::size_t row = static_cast<std::size_t>(wish.width) * (yuyv ? 2 : 1);
  if (stride < row || bytes.size() < stride * static_cast<std::size_t>(wish.height - 1) + row)
    return {{}, true};
  // OpenCV does not write to what this Mat points to.
  const cv::Mat buffer(wish.height, wish.width, yuyv ? CV_8UC2 : CV_8UC1,
                       const_cast<std::byte*>(bytes.data()), stride);
  cv::Mat brightness;
  if (yuyv) {
    cv::extractChannel(buffer, brightness, 0);
  } else {
    buffer.copyTo(brightness);
  }
  return {shrunk(brightness, wish.shrink), false};
}

}  // namespace slipd::camera
