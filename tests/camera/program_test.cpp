// The real slipd-camera on rendered videos: its frames are the truth.
#include "tests/support/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "push_layout/layout.hpp"
#include "tests/camera/rendered_gel.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::testing {
namespace {

using ::testing::HasSubstr;

constexpr double kRateHz = 20;
constexpr std::size_t kNodes = 6;
constexpr const char* kGelProfile =
    R"({ "description": "rendered", "picture": { "width": 320, "height": 240 },
  "surface": { "follow": "dots", "mm_per_px": 0.1 }, "nodes": { "rows": 2, "columns": 3, "pitch_mm": 5 } })";

struct SentFrame {
  push_layout::FrameHead head;
  std::vector<float> values;
};

std::vector<SentFrame> frames_in(const std::string& bytes) {
  push_layout::Hello hello;
  EXPECT_GE(bytes.size(), sizeof hello);
  std::memcpy(&hello, bytes.data(), sizeof hello);
  EXPECT_EQ(hello.magic, push_layout::kMagic);
  EXPECT_EQ(hello.unit, push_layout::Unit::millimetre);
  EXPECT_EQ(hello.axes, 3);
  EXPECT_EQ(hello.taxels, kNodes);
  EXPECT_EQ(hello.rate_hz, kRateHz);
  std::vector<SentFrame> frames;
  const std::size_t size = push_layout::frame_size(kNodes, 3);
  for (std::size_t at = sizeof hello; at < bytes.size(); at += size) {
    SentFrame frame{{}, std::vector<float>(3 * kNodes)};
    EXPECT_LE(at + size, bytes.size());
    std::memcpy(&frame.head, bytes.data() + at, sizeof frame.head);
    EXPECT_EQ(frame.head.size, size);
    std::memcpy(frame.values.data(), bytes.data() + at + sizeof frame.head, size - sizeof frame.head);
    frames.push_back(std::move(frame));
  }
  return frames;
}

class CameraProgram : public ::testing::Test {
 protected:
  Ran read(const std::vector<cv::Mat>& pictures, std::vector<std::string> more = {"--frames", "-"}) {
    std::ofstream(folder_.path() / "gel.json") << kGelProfile;
    write_video(folder_.path() / "gel.avi", pictures, kRateHz);
    std::vector<std::string> command{program_folder() / "slipd-camera", "--file", folder_.path() / "gel.avi",
                                     "--profile", folder_.path() / "gel.json"};
    command.insert(command.end(), more.begin(), more.end());
    return run(command);
  }

  TempFolder folder_;
  RenderedGel gel_{.spacing = 30, .radius = 5};
};

TEST_F(CameraProgram, writes_one_frame_for_each_picture_with_its_time_and_the_true_displacement) {
  std::vector<cv::Mat> pictures;
  for (std::uint32_t i = 0; i < 10; ++i)
    pictures.push_back(rendered(
        gel_, [&](cv::Point2f) { return cv::Point2f(static_cast<float>(i), 0.5F * static_cast<float>(i)); },
        i));
  const Ran ran = read(pictures);
  ASSERT_EQ(ran.code, 0) << ran.errors;
  const auto frames = frames_in(ran.output);
  ASSERT_EQ(frames.size(), pictures.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].head.flags, 0);
    EXPECT_EQ(frames[i].head.sequence, i + 1);
    EXPECT_EQ(frames[i].head.time_ns, static_cast<std::int64_t>(i + 1) * 50'000'000);
    for (std::size_t node = 0; node < kNodes; ++node) {  // of ten pixels a mm
      EXPECT_NEAR(frames[i].values[3 * node], 0.1 * static_cast<double>(i), 0.01);
      EXPECT_NEAR(frames[i].values[3 * node + 1], 0.05 * static_cast<double>(i), 0.01);
    }
  }
}

TEST_F(CameraProgram, marks_dark_and_frozen_pictures_as_bad) {
  const auto rest = [](cv::Point2f) { return cv::Point2f{}; };
  std::vector<cv::Mat> pictures{rendered(gel_, rest, 0) / 10};
  for (std::uint32_t i = 1; i < 4; ++i) pictures.push_back(rendered(gel_, rest, i));
  for (int i = 0; i < 20; ++i) pictures.push_back(pictures.back());
  const auto frames = frames_in(read(pictures).output);
  ASSERT_EQ(frames.size(), pictures.size());
  EXPECT_EQ(frames[0].head.flags, push_layout::kBad);
  EXPECT_TRUE(std::isnan(frames[0].values[0]));
  EXPECT_EQ(frames[3].head.flags, 0);
  EXPECT_EQ(frames.back().head.flags, push_layout::kBad);
}

TEST_F(CameraProgram, draws_what_it_sees) {
  const auto rest = [](cv::Point2f) { return cv::Point2f{}; };
  const Ran ran = read({rendered(gel_, rest, 0)}, {"--view", folder_.path() / "view.png"});
  EXPECT_EQ(ran.code, 0) << ran.errors;
  EXPECT_GT(std::filesystem::file_size(folder_.path() / "view.png"), 1000U);
}

TEST_F(CameraProgram, says_what_is_wrong_and_what_there_is_instead) {
  const std::string camera = program_folder() / "slipd-camera";
  const Ran profile = run({camera, "--file", "a.avi", "--profile", "gelsite", "--frames", "-"});
  EXPECT_EQ(profile.code, 2);
  EXPECT_THAT(profile.errors, HasSubstr("own-dots"));
  const Ran file = run({camera, "--file", "/none.avi", "--profile", "own-dots", "--frames", "-"});
  EXPECT_EQ(file.code, 1);
  EXPECT_THAT(file.errors, HasSubstr("/none.avi"));
  const Ran device =
      run({camera, "--device", "/dev/null", "--profile", "own-dots", "--view", "/dev/null.png"});
  EXPECT_EQ(device.code, 1);
  EXPECT_THAT(device.errors, HasSubstr("is no camera"));
}

}  // namespace
}  // namespace slipd::testing
