#include "camera/view/view.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace slipd::camera {
namespace {

// The picture is drawn at least this wide, px.
constexpr int kWidth = 960;
// Arrows are as many times longer than the displacement.
constexpr float kArrow = 4;
const cv::Scalar kSeen(80, 220, 80), kLost(60, 60, 255), kMoved(0, 220, 255);  // blue, green, red

}  // namespace

void write_view(const std::string& path, const GelReader& reader, std::span<const float> values) {
  if (reader.gel().empty())
    throw std::runtime_error(path + ": there is no picture to show; is the lens covered, or the lamp off?");
  const int times = std::max(1, kWidth / reader.gel().cols);
  const auto scale = static_cast<float>(times);
  cv::Mat out;
  cv::resize(reader.gel(), out, {}, scale, scale, cv::INTER_NEAREST);
  cv::cvtColor(out, out, cv::COLOR_GRAY2BGR);
  const auto drawn = [&](cv::Point2f at) { return cv::Point((at + cv::Point2f(0.5F, 0.5F)) * scale); };
  if (!values.empty()) {
    const int radius = static_cast<int>(std::lround(reader.radius_px() * scale));
    for (const SurfacePoint& point : reader.points())
      cv::circle(out, drawn(point.now), radius, point.seen ? kSeen : kLost, 1, cv::LINE_AA);
    for (std::size_t i = 0; i < reader.nodes_px().size(); ++i) {
      const cv::Point2f from = reader.nodes_px()[i];
      const cv::Point2f moved(values[NodeGrid::kValues * i], values[NodeGrid::kValues * i + 1]);
      if (std::isnan(moved.x)) continue;
      cv::arrowedLine(out, drawn(from),
                      drawn(from + moved * (kArrow / static_cast<float>(reader.mm_per_px()))), kMoved, 1,
                      cv::LINE_AA);
    }
  }
  if (!cv::imwrite(path, out)) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace slipd::camera
