#include "tests/camera/rendered_gel.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <random>
#include <stdexcept>

namespace slipd::testing {
namespace {

constexpr int kParts = 8;  // of a pixel, along each side

// The share of a pixel that a disc covers.
double covered(double x, double y, double radius) {
  int inside = 0;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j) {
      const double dx = x + (i + 0.5) / kParts - 0.5, dy = y + (j + 0.5) / kParts - 0.5;
      inside += dx * dx + dy * dy < radius * radius ? 1 : 0;
    }
  }
  return static_cast<double>(inside) / (kParts * kParts);
}

}  // namespace

std::vector<cv::Point2f> resting_dots(const RenderedGel& gel) {
  std::mt19937 random(gel.seed);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<cv::Point2f> dots;
  for (double y = gel.spacing / 2; y < gel.height; y += gel.spacing) {
    for (double x = gel.spacing / 2; x < gel.width; x += gel.spacing) {
      if (share(random) >= gel.missing) dots.emplace_back(static_cast<float>(x), static_cast<float>(y));
    }
  }
  return dots;
}

cv::Mat rendered(const RenderedGel& gel, const Displacement& moved, std::uint32_t picture) {
  cv::Mat dark = cv::Mat::zeros(gel.height, gel.width, CV_64F);
  for (const cv::Point2f rest : resting_dots(gel)) {
    const cv::Point2f at = rest + moved(rest);
    const int reach = static_cast<int>(gel.radius) + 2;
    for (int y = cvRound(at.y) - reach; y <= cvRound(at.y) + reach; ++y) {
      for (int x = cvRound(at.x) - reach; x <= cvRound(at.x) + reach; ++x) {
        if (x >= 0 && y >= 0 && x < gel.width && y < gel.height)
          dark.at<double>(y, x) =
              std::min(1.0, dark.at<double>(y, x) + covered(x - at.x, y - at.y, gel.radius));
      }
    }
  }
  std::mt19937 random(picture);
  std::normal_distribution<double> noise(0, std::max(gel.noise, 1e-9));
  cv::Mat out(gel.height, gel.width, CV_8U);
  for (int y = 0; y < gel.height; ++y) {
    for (int x = 0; x < gel.width; ++x) {
      const double ground = gel.gel - gel.shade * x / gel.width;
      const double share = dark.at<double>(y, x);
      out.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(ground + share * (gel.dot - ground) + noise(random));
    }
  }
  return out;
}

Displacement press(const RenderedGel& gel, float x, float y, float spread) {
  const cv::Point2f middle(static_cast<float>(gel.width) / 2, static_cast<float>(gel.height) / 2);
  const float size = static_cast<float>(gel.width) / 3;
  return [=](cv::Point2f rest) {
    const cv::Point2f out = (rest - middle) / size;
    return (cv::Point2f(x, y) + out * spread) * std::exp(-out.dot(out));
  };
}

void write_video(const std::string& path, const std::vector<cv::Mat>& pictures, double rate_hz) {
  cv::VideoWriter video(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), rate_hz,
                        pictures.front().size(), false);
  if (!video.isOpened()) throw std::runtime_error(path + ": cannot be written");
  for (const cv::Mat& picture : pictures) video.write(picture);
}

}  // namespace slipd::testing
