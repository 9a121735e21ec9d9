#include "camera/frames/gel_reader.hpp"

#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "camera/surface/displacement_field.hpp"

namespace slipd::camera {
namespace {

bool same(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size()) return false;
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), static_cast<std::size_t>(a.cols)) != 0) return false;
  }
  return true;
}

cv::Mat cropped(const Picture& picture, const PictureWish& wish) {
  if (!wish.crop) return picture.brightness;
  const cv::Rect all({}, picture.brightness.size());
  if ((*wish.crop & all) != *wish.crop)
    throw std::runtime_error("the picture has " + std::to_string(all.width) + " x " +
                             std::to_string(all.height) +
                             " pixels, and the profile's picture.crop reaches beyond: make them agree");
  return picture.brightness(*wish.crop);
}

}  // namespace

GelReader::GelReader(Profile profile, GelReaderOptions options)
    : profile_(std::move(profile)),
      options_(options),
      tracker_(make_tracker(profile_.surface)),
      mm_per_px_(profile_.surface.mm_per_px) {}

bool GelReader::usable(const Picture& picture) {
  if (picture.brightness.empty() || picture.torn) return false;
  gel_ = cropped(picture, profile_.picture);
  repeats_ = same(gel_, last_) ? repeats_ + 1 : 0;
  last_ = gel_;
  return repeats_ < options_.most_repeats && cv::mean(gel_)[0] >= options_.least_brightness;
}

// Where a point would be with a straight lens, px.
cv::Point2f GelReader::unbent(cv::Point2f at) const {
  const auto half = static_cast<float>(gel_.cols) / 2;
  const cv::Point2f middle(static_cast<float>(gel_.cols - 1) / 2, static_cast<float>(gel_.rows - 1) / 2);
  const cv::Point2f out = at - middle;
  return middle + out * static_cast<float>(1 + profile_.surface.bend * out.dot(out) / (half * half));
}

std::vector<SurfacePoint> GelReader::unbent(const std::vector<SurfacePoint>& points) const {
  std::vector<SurfacePoint> out = points;
  for (SurfacePoint& point : out) {
    point.rest = unbent(point.rest);
    point.now = unbent(point.now);
  }
  return out;
}

void GelReader::place_nodes() {
  if (profile_.surface.mm_per_px == 0) mm_per_px_ = profile_.surface.pitch_mm / tracker_->spacing_px();
  const NodeGrid& grid = profile_.nodes;
  const double pitch = grid.pitch_mm / mm_per_px_;
  nodes_px_.clear();
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column)
      nodes_px_.emplace_back(
          static_cast<float>((gel_.cols - 1) / 2.0 + (column - (grid.columns - 1) / 2.0) * pitch),
          static_cast<float>((gel_.rows - 1) / 2.0 + (row - (grid.rows - 1) / 2.0) * pitch));
  }
  if ((grid.columns - 1) * pitch >= gel_.cols || (grid.rows - 1) * pitch >= gel_.rows)
    throw std::runtime_error("the profile's nodes reach beyond the picture, which shows " +
                             std::to_string(gel_.cols * mm_per_px_) + " x " +
                             std::to_string(gel_.rows * mm_per_px_) +
                             " mm: fewer rows or columns, a smaller pitch_mm, or another mm_per_px");
}

bool GelReader::take_rest() {
  if (!tracker_->rest(gel_)) return false;
  place_nodes();
  change_.rest(gel_);
  resting_ = true;
  return true;
}

std::span<const float> GelReader::read(const Picture& picture) {
  points_.clear();
  if (!usable(picture) || (!resting_ && !take_rest())) return {};
  points_ = tracker_->follow(gel_);
  const auto moved = displacement_at(nodes_px_, profile_.surface.bend == 0 ? points_ : unbent(points_),
                                     tracker_->spacing_px());
  const auto changed = change_.at(gel_, nodes_px_, profile_.nodes.pitch_mm / mm_per_px_);
  values_.resize(NodeGrid::kValues * nodes_px_.size());
  const auto scale = static_cast<float>(mm_per_px_);
  for (std::size_t i = 0; i < nodes_px_.size(); ++i) {
    values_[NodeGrid::kValues * i] = moved[i].x * scale;
    values_[NodeGrid::kValues * i + 1] = moved[i].y * scale;
    values_[NodeGrid::kValues * i + 2] = changed[i];
  }
  return values_;
}

}  // namespace slipd::camera
