#include "camera/surface/dot_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slipd::camera {
namespace {

// Half widths of the squares whose means are compared, in radii of a dot: the dot's own, and that of its
// surroundings.
constexpr double kDotHalfWidth = 0.6;
constexpr double kSurroundings = 3;
// Radius of the disc that the centroid is taken over, in radii of a dot.
constexpr double kCentroidRadius = 1.7;
// Pixels with less than this share of the dot's darkness are gel.
constexpr float kGelShare = 0.25F;
constexpr int kCentroidSteps = 2;
// Radii that are tried where none is given, px.
constexpr std::array kRadii{2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0};
// Dots that make a pattern.
constexpr std::size_t kFewest = 6;

int odd_width(double half_width) {
  return 2 * std::max(1, static_cast<int>(std::lround(half_width))) + 1;
}

}  // namespace

void DotFinder::contrast_of(const cv::Mat& picture, double radius) {
  const int small = odd_width(kDotHalfWidth * radius);
  const int large = odd_width(kSurroundings * radius);
  cv::boxFilter(picture, small_, CV_32F, {small, small});
  cv::boxFilter(picture, large_, CV_32F, {large, large});
  contrast_.create(picture.size(), CV_32F);
  const float sign = options_.bright ? -1.0F : 1.0F;
  for (int y = 0; y < picture.rows; ++y) {
    const auto* dot = small_.ptr<float>(y);
    const auto* around = large_.ptr<float>(y);
    auto* out = contrast_.ptr<float>(y);
    for (int x = 0; x < picture.cols; ++x) out[x] = sign * (around[x] - dot[x]) / (around[x] + 1.0F);
  }
}

void DotFinder::peaks_above(float least, double radius) {
  const int width = odd_width(radius);
  cv::dilate(contrast_, highest_, cv::Mat::ones(width, width, CV_8U));
  dots_.clear();
  const int edge = static_cast<int>(radius);
  for (int y = edge; y < contrast_.rows - edge; ++y) {
    const auto* here = contrast_.ptr<float>(y);
    const auto* highest = highest_.ptr<float>(y);
    for (int x = edge; x < contrast_.cols - edge; ++x) {
      if (here[x] > least && here[x] == highest[x])
        dots_.push_back({cv::Point2f(static_cast<float>(x), static_cast<float>(y)), here[x]});
    }
  }
  std::sort(dots_.begin(), dots_.end(), [](const Dot& a, const Dot& b) { return a.contrast > b.contrast; });
}

// How many of the strongest peaks differ most from the rest: Otsu's criterion over their contrasts.
float DotFinder::split_of_peaks() const {
  const std::size_t n = dots_.size();
  double total = 0;
  for (const Dot& dot : dots_) total += dot.contrast;
  double above = 0, best = -1;
  std::size_t split = n;
  for (std::size_t i = 1; i < n; ++i) {
    above += dots_[i - 1].contrast;
    const auto high = static_cast<double>(i), low = static_cast<double>(n - i);
    const double difference = above / high - (total - above) / low;
    if (const double between = high * low * difference * difference; between > best) {
      best = between;
      split = i;
    }
  }
  return static_cast<float>(split);
}

void DotFinder::learn(const cv::Mat& picture) {
  double best = 0;
  for (const double radius : kRadii) {
    if (options_.radius_px > 0 && radius != kRadii.front()) break;
    const double tried = options_.radius_px > 0 ? options_.radius_px : radius;
    contrast_of(picture, tried);
    peaks_above(static_cast<float>(options_.least_contrast), tried);
    const auto strong = static_cast<std::size_t>(split_of_peaks());
    if (strong < kFewest) continue;
    const float usual = dots_[strong / 2].contrast;
    if (usual > best) {
      best = usual;
      radius_ = tried;
      usual_contrast_ = usual;
    }
  }
}

void DotFinder::to_centroid(const cv::Mat& picture, Dot& dot) const {
  const float reach = static_cast<float>(kCentroidRadius * radius_);
  const float around = large_.at<float>(static_cast<int>(dot.place.y), static_cast<int>(dot.place.x));
  const float floor = kGelShare * dot.contrast * around;
  const float sign = options_.bright ? -1.0F : 1.0F;
  for (int step = 0; step < kCentroidSteps; ++step) {
    const cv::Point2f middle = dot.place;
    const int top = std::max(0, static_cast<int>(std::ceil(middle.y - reach)));
    const int bottom = std::min(picture.rows - 1, static_cast<int>(std::floor(middle.y + reach)));
    float mass = 0, mass_x = 0, mass_y = 0;
    for (int y = top; y <= bottom; ++y) {
      const float up = static_cast<float>(y) - middle.y;
      const float half = std::sqrt(std::max(0.0F, reach * reach - up * up));
      const int left = std::max(0, static_cast<int>(std::ceil(middle.x - half)));
      const int right = std::min(picture.cols - 1, static_cast<int>(std::floor(middle.x + half)));
      const auto* row = picture.ptr<std::uint8_t>(y);
      for (int x = left; x <= right; ++x) {
        const float dark = std::max(0.0F, sign * (around - static_cast<float>(row[x])) - floor);
        mass += dark;
        mass_x += dark * (static_cast<float>(x) - middle.x);
        mass_y += dark * up;
      }
    }
    if (!(mass > 0)) return;
    dot.place += cv::Point2f(mass_x / mass, mass_y / mass);
  }
}

const std::vector<Dot>& DotFinder::find(const cv::Mat& picture) {
  if (!(usual_contrast_ > 0)) learn(picture);
  dots_.clear();
  if (!(usual_contrast_ > 0)) return dots_;
  contrast_of(picture, radius_);
  const auto least = static_cast<float>(
      std::max(options_.least_contrast, options_.share_of_usual * static_cast<double>(usual_contrast_)));
  peaks_above(least, radius_);
  for (Dot& dot : dots_) to_centroid(picture, dot);
  return dots_;
}

}  // namespace slipd::camera
