// Videos of gels under grasps whose slides are known, through the real slipd-camera and the chain behind it.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "lab/gels/gel_frames.hpp"
#include "tests/camera/rendered_gel.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::testing {
namespace {

using lab::GelCourse;
using lab::GelFrames;
using lab::GelGrasp;

constexpr double kPicturesHz = 25, kMPerPx = 0.058e-3;  // the scale of the profile own-dots
constexpr const char* kScene = R"({ "sensors": [ { "name": "finger", "driver": "push", "rate_hz": 25,
  "layout": { "grid": [9, 7], "pitch_mm": 1.8 }, "options": { "unit": "mm", "camera_profile": "own-dots" } } ] })";

class RenderedSlide : public ::testing::Test {
 protected:
  // Times of estimates with an alert of slip, s from the first picture.
  std::vector<double> slips_of(const GelGrasp& grasp) {
    std::ofstream(folder_.path() / "scene.json") << kScene;
    write_video(folder_.path() / "finger.avi", pictures_of(grasp), kPicturesHz);
    const Ran ran = run({program_folder() / "sliplab", "replay", "--scene", folder_.path() / "scene.json",
                         "--file", "finger=" + (folder_.path() / "finger.avi").string(), "--estimates", "-"});
    EXPECT_EQ(ran.code, 0) << ran.errors;
    return slips_in(ran.output);
  }

 private:
  std::vector<cv::Mat> pictures_of(const GelGrasp& grasp) const {
    GelFrames frames(grasp, surface_, layout_, kPicturesHz, 0, RandomStream(1));
    std::vector<cv::Mat> pictures;
    while (frames.next()) {
      const auto moved = [&](cv::Point2f rest) {
        const auto at = frames.moved(kMPerPx * static_cast<double>(rest.x - 160),
                                     kMPerPx * static_cast<double>(rest.y - 120));
        return cv::Point2f(static_cast<float>(at.x_m / kMPerPx), static_cast<float>(at.y_m / kMPerPx));
      };
      pictures.push_back(rendered(gel_, moved, static_cast<std::uint32_t>(frames.moment().number)));
    }
    return pictures;
  }

  static std::vector<double> slips_in(const std::string& table) {
    std::istringstream lines(table);
    std::string line;
    std::getline(lines, line);
    const auto names = row_fields(line);
    const auto column = [&](const char* name) {
      return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    const std::size_t time = column("time_s"), alert = column("alert");
    std::vector<double> slips;
    std::size_t rows = 0;
    for (; std::getline(lines, line); ++rows) {
      const auto cells = row_fields(line);
      if (cells.at(alert) == "slip") slips.push_back(std::stod(cells.at(time)));
    }
    EXPECT_GT(rows, 50U);
    return slips;
  }

  const lab::GelSurface surface_{GelFrames::kThickness_m, GelFrames::kPoisson};
  const TaxelLayout layout_ = TaxelLayout::grid(9, 7, 0.0018);
  const RenderedGel gel_{.spacing = 30, .radius = 5, .missing = 0.1};
  TempFolder folder_;
};

TEST_F(RenderedSlide, IsToldWithinThreePicturesAfterTheObjectIsLostAndNotBeforeItSlides) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const GelGrasp grasp = lab::draw_gel_grasp(GelCourse::falls, RandomStream(seed));
    const std::vector<double> slips = slips_of(grasp);
    ASSERT_FALSE(slips.empty());
    EXPECT_GE(slips.front(), grasp.slides_s);
    EXPECT_LE(slips.front(), grasp.lost_s + 3 / kPicturesHz);
  }
}

TEST_F(RenderedSlide, IsNotToldWhereTheGripIsEased) {
  EXPECT_TRUE(slips_of(lab::draw_gel_grasp(GelCourse::eased, RandomStream(1))).empty());
}

}  // namespace
}  // namespace slipd::testing
