#include "camera/surface/surface_tracker.hpp"

#include "camera/surface/dot_finder.hpp"
#include "camera/surface/dot_tracker.hpp"
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
    return true;
  }
  const std::vector<SurfacePoint>& follow(const cv::Mat& picture) override {
    return tracker_.follow(finder_.find(picture));
  }
  double spacing_px() const override { return tracker_.spacing_px(); }
  double radius_px() const override { return finder_.radius_px(); }

 private:
  DotFinder finder_;
  DotTracker tracker_;
};

}  // namespace

std::unique_ptr<SurfaceTracker> make_tracker(const SurfaceFacts& facts) {
  if (facts.texture) return std::make_unique<TextureTracker>();
  return std::make_unique<Dots>(facts);
}

}  // namespace slipd::camera
