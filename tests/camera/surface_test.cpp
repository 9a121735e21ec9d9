// Dots and texture of rendered gels are followed, and the field is the true one.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "camera/frames/gel_reader.hpp"
#include "camera/surface/dot_finder.hpp"
#include "camera/surface/surface_tracker.hpp"
#include "tests/camera/rendered_gel.hpp"

namespace slipd::camera {
namespace {

using slipd::testing::Displacement;
using slipd::testing::RenderedGel;

// Issued for dots of five pixels; the noise of a dot at rest may be as large.
constexpr double kGoodPx = 0.05;

Displacement still() {
  return [](cv::Point2f) { return cv::Point2f{}; };
}

Profile profile_of_gel() {
  Profile profile;
  profile.picture = {.width = 320, .height = 240, .rate_hz = 25, .crop = {}};
  profile.surface.mm_per_px = 0.1;
  profile.nodes = {.rows = 7, .columns = 9, .pitch_mm = 3};
  return profile;
}

Picture picture_of(const cv::Mat& brightness) {
  return {.brightness = brightness};
}

// rms over the nodes, px. NaN if a node is not seen.
double error_of(std::span<const float> values, const GelReader& reader, const Displacement& truth) {
  double sum = 0;
  const auto& nodes = reader.nodes_px();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const cv::Point2f told(values[3 * i], values[3 * i + 1]);
    const cv::Point2f wrong = told / static_cast<float>(reader.mm_per_px()) - truth(nodes[i]);
    sum += wrong.dot(wrong);
  }
  return std::sqrt(sum / static_cast<double>(nodes.size()));
}

TEST(DotFinder, finds_all_dots_and_nothing_else_of_any_size_and_tone_that_it_is_not_told) {
  for (const double radius : {2.5, 5.0, 9.0}) {
    for (const bool bright : {false, true}) {
      const RenderedGel gel{.spacing = 5 * radius,
                            .radius = radius,
                            .gel = bright ? 100.0 : 150.0,
                            .dot = bright ? 220.0 : 40.0};
      DotFinder finder({.bright = bright});
      const auto& found = finder.find(rendered(gel, still(), 1));
      const auto there = resting_dots(gel);
      std::size_t met = 0, whole = 0;
      for (const cv::Point2f dot : there) {
        const bool near_edge = dot.x + radius > 319 || dot.y + radius > 239;
        whole += near_edge ? 0 : 1;
        for (const Dot& one : found) met += !near_edge && cv::norm(one.place - dot) < 0.3 ? 1 : 0;
      }
      EXPECT_EQ(met, whole) << "radius " << radius << (bright ? ", bright" : "");
      EXPECT_LE(found.size(), there.size());
    }
  }
}

TEST(GelReader, tells_the_true_field_of_dots_of_five_pixels_with_a_fifth_of_them_missing) {
  const RenderedGel gel{.missing = 0.2};
  GelReader reader(profile_of_gel());
  reader.read(picture_of(rendered(gel, still(), 0)));
  double sum = 0;
  constexpr int kPictures = 20;
  for (int i = 1; i <= kPictures; ++i) {
    const auto along = static_cast<float>(i) / kPictures;
    const Displacement truth = press(gel, 6 * along, -4 * along, 5 * along);
    const double error =
        error_of(reader.read(picture_of(rendered(gel, truth, static_cast<std::uint32_t>(i)))), reader, truth);
    sum += error * error;
  }
  EXPECT_LE(std::sqrt(sum / kPictures), kGoodPx);
}

TEST(GelReader, follows_a_sudden_step_of_nearly_half_the_spacing) {
  const RenderedGel gel{.missing = 0.1};
  GelReader reader(profile_of_gel());
  reader.read(picture_of(rendered(gel, still(), 0)));
  const Displacement step = press(gel, 0.45F * 20, 0, 0);
  EXPECT_LE(error_of(reader.read(picture_of(rendered(gel, step, 1))), reader, step), 4 * kGoodPx);
}

TEST(GelReader, says_that_nothing_is_seen_where_dots_are_covered_and_finds_them_again) {
  const RenderedGel gel;
  GelReader reader(profile_of_gel());
  const cv::Mat whole = rendered(gel, still(), 0);
  reader.read(picture_of(whole));
  cv::Mat covered = rendered(gel, still(), 1);
  cv::rectangle(covered, cv::Rect(0, 0, 160, 240), cv::Scalar(150), cv::FILLED);
  const auto half = reader.read(picture_of(covered));
  EXPECT_TRUE(std::isnan(half[0]));       // the left upper node
  EXPECT_FALSE(std::isnan(half[3 * 8]));  // the right upper one
  EXPECT_LE(error_of(reader.read(picture_of(rendered(gel, still(), 2))), reader, still()), kGoodPx);
}

TEST(GelReader, tells_a_change_of_the_picture_where_it_is_and_not_that_of_the_light) {
  const RenderedGel gel;
  GelReader reader(profile_of_gel());
  reader.read(picture_of(rendered(gel, still(), 0)));
  RenderedGel brighter = gel;
  brighter.gel += 20;
  brighter.dot += 20;
  cv::Mat picture = rendered(brighter, still(), 1);
  cv::rectangle(picture, cv::Rect(15, 15, 30, 30), cv::Scalar(255), cv::FILLED);
  const auto values = reader.read(picture_of(picture));
  EXPECT_GT(values[2], 0.2F);            // around the left upper node
  EXPECT_LT(values[3 * 62 + 2], 0.02F);  // around the right lower one: twice the noise of a pixel
}

TEST(GelReader, uses_no_picture_that_is_dark_torn_or_the_same_again_and_again) {
  const RenderedGel gel;
  const cv::Mat good = rendered(gel, still(), 0);
  GelReader reader(profile_of_gel(), {.most_repeats = 3});
  EXPECT_TRUE(reader.read({}).empty());
  EXPECT_TRUE(reader.read(picture_of(good / 10)).empty());
  EXPECT_TRUE(reader.read({.brightness = good, .torn = true}).empty());
  EXPECT_FALSE(reader.read(picture_of(good)).empty());
  EXPECT_FALSE(reader.read(picture_of(good.clone())).empty());
  EXPECT_FALSE(reader.read(picture_of(good.clone())).empty());
  EXPECT_TRUE(reader.read(picture_of(good.clone())).empty());
  EXPECT_FALSE(reader.read(picture_of(rendered(gel, still(), 1))).empty());
}

TEST(GelReader, takes_the_scale_from_the_pitch_of_the_dots) {
  Profile profile = profile_of_gel();
  profile.surface.mm_per_px = 0;
  profile.surface.pitch_mm = 2;
  GelReader reader(profile);
  reader.read(picture_of(rendered(RenderedGel{}, still(), 0)));
  EXPECT_NEAR(reader.mm_per_px(), 0.1, 0.001);
}

TEST(TextureTracker, follows_texture_without_dots) {
  cv::Mat texture(300, 400, CV_8U);
  cv::theRNG().state = 3;
  cv::randu(texture, 60, 200);
  cv::GaussianBlur(texture, texture, {}, 1.5);
  const auto shifted = [&](float x, float y) {
    cv::Mat out;
    cv::getRectSubPix(texture, {320, 240}, cv::Point2f(200 - x, 150 - y), out);
    return out;
  };
  const auto tracker = make_tracker({.texture = true});
  ASSERT_TRUE(tracker->rest(shifted(0, 0)));
  for (const float step : {0.3F, 2.7F, 9.4F}) {
    std::size_t right = 0;
    const auto& points = tracker->follow(shifted(step, -step / 2));
    for (const SurfacePoint& point : points)
      right += point.seen && cv::norm(point.now - point.rest - cv::Point2f(step, -step / 2)) < 0.1 ? 1 : 0;
    EXPECT_GT(right, points.size() * 8 / 10) << step;
  }
}

}  // namespace
}  // namespace slipd::camera
