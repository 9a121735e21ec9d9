#include "camera/surface/surface_tracker.hpp"

#include <algorithm>

#include "camera/surface/dot_finder.hpp"
#include "camera/surface/dot_tracker.hpp"
#include "camera/surface/printed_grid.hpp"
#include "camera/surface/texture_tracker.hpp"

namespace slipd::camera {
namespace {

// With fewer dots there is no field.
constexpr std::size_t kFewestDots = 6;

class Dots final : public SurfaceTracker {
 public:
  explicit Dots(const SurfaceFacts& facts)
      : finder_({.radius_px = facts.radius_px, .bright = facts.bright}), tracker_({}) {}

  bool rest(const cv::Mat& picture) override {
    finder_.learn(picture);
    const auto& dots = finder_.find(picture);
    if (dots.size() < kFewestDots) return false;
    tracker_.rest(dots);
    find_grid(dots);
    return true;
  }
  const std::vector<SurfacePoint>& follow(const cv::Mat& picture) override {
    points_ = tracker_.follow(finder_.find(picture));
    for (std::size_t i = 0; i < points_.size() && !first_.empty(); ++i)
      points_[i].rest += to_grid_[i < first_.size() ? i : nearest_first(points_[i].rest)];
    return points_;
  }
  double spacing_px() const override { return tracker_.spacing_px(); }
  double radius_px() const override { return finder_.radius_px(); }

 private:
  // The first picture may show a contact: dots of a printed grid are at rest where the grid is.
  void find_grid(const std::vector<Dot>& dots) {
    first_.clear();
    to_grid_.clear();
    for (const Dot& dot : dots) first_.push_back(dot.place);
    const auto places = on_printed_grid(first_, tracker_.spacing_px());
    if (places.empty()) return first_.clear();
    for (std::size_t i = 0; i < places.size(); ++i) to_grid_.push_back(places[i] - first_[i]);
  }
  // For a dot that came later.
  std::size_t nearest_first(cv::Point2f place) const {
    const auto nearest = std::ranges::min_element(
        first_, {}, [&](cv::Point2f each) { return (each - place).dot(each - place); });
    return static_cast<std::size_t>(nearest - first_.begin());
  }

  DotFinder finder_;
  DotTracker tracker_;
  std::vector<cv::Point2f> first_,
      to_grid_;  // of the first dots: place, and from there to the grid; none: no grid
  std::vector<SurfacePoint> points_;
};

}  // namespace

std::unique_ptr<SurfaceTracker> make_tracker(const SurfaceFacts& facts) {
  if (facts.texture) return std::make_unique<TextureTracker>();
  return std::make_unique<Dots>(facts);
}

}  // namespace slipd::camera
