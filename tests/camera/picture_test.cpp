// Pictures are decoded, and what is wrong with one is seen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <chrono>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "camera/picture/played_video.hpp"
#include "camera/picture/raw_picture.hpp"
#include "camera/service/picture_thread.hpp"
#include "tests/camera/rendered_gel.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::camera {
namespace {

cv::Mat still_gel() {
  return slipd::testing::rendered(
      {}, [](cv::Point2f) { return cv::Point2f{}; }, 0);
}

std::vector<std::uint8_t> jpeg_of(const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", picture, bytes);
  return bytes;
}

const PictureWish kMjpeg{.width = 320, .height = 240, .rate_hz = 25, .crop = {}};

TEST(Decode, gives_the_brightness_of_each_format) {
  const cv::Mat picture = still_gel();
  const auto jpeg = jpeg_of(picture);
  const Decoded mjpeg = decode(std::as_bytes(std::span(jpeg)), kMjpeg, 0);
  EXPECT_FALSE(mjpeg.torn);
  EXPECT_LT(cv::norm(mjpeg.brightness, picture, cv::NORM_L1) / static_cast<double>(picture.total()), 2);

  PictureWish wish = kMjpeg;
  wish.format = PictureFormat::grey;
  const std::span grey(picture.ptr(), picture.total());
  EXPECT_EQ(cv::norm(decode(std::as_bytes(grey), wish, 320).brightness, picture, cv::NORM_INF), 0);

  wish.format = PictureFormat::yuyv;
  cv::Mat yuyv;
  cv::merge(std::vector{picture, cv::Mat(picture.size(), CV_8U, cv::Scalar(128))}, yuyv);
  const std::span pairs(yuyv.ptr(), yuyv.total() * 2);
  EXPECT_EQ(cv::norm(decode(std::as_bytes(pairs), wish, 640).brightness, picture, cv::NORM_INF), 0);
}

TEST(Decode, makes_pictures_smaller) {
  const auto jpeg = jpeg_of(still_gel());
  PictureWish wish = kMjpeg;
  wish.shrink = 4;
  const Decoded small = decode(std::as_bytes(std::span(jpeg)), wish, 0);
  EXPECT_EQ(small.brightness.size(), cv::Size(80, 60));
  EXPECT_NEAR(cv::mean(small.brightness)[0], cv::mean(still_gel())[0], 1);
}

TEST(Decode, sees_that_a_jpeg_is_torn_wherever_it_ends) {
  const auto jpeg = jpeg_of(still_gel());
  for (std::size_t size = 0; size < jpeg.size() - 2; size += 97)
    EXPECT_TRUE(decode(std::as_bytes(std::span(jpeg).first(size)), kMjpeg, 0).torn) << size;
}

TEST(Decode, refuses_a_picture_of_another_size_and_one_that_is_too_short) {
  const auto jpeg = jpeg_of(still_gel());
  PictureWish wish = kMjpeg;
  wish.width = 640;
  EXPECT_TRUE(decode(std::as_bytes(std::span(jpeg)), wish, 0).brightness.empty());
  wish.format = PictureFormat::grey;
  EXPECT_TRUE(decode(std::as_bytes(std::span(jpeg)), wish, 640).torn);
}

// A camera that is not there at first, gives a picture, and goes.
class ShyCamera final : public PictureSource {
 public:
  std::optional<Picture> next() override {
    if (std::exchange(gave_, true)) throw std::runtime_error("gone");
    return Picture{};
  }
  double rate_hz() const noexcept override { return 25; }

 private:
  bool gave_ = false;
};

TEST(PictureThread, tells_trouble_and_opens_a_camera_that_comes_back) {
  int opened = 0;
  PictureThread pictures([&]() -> std::unique_ptr<PictureSource> {
    if (++opened == 1) throw std::runtime_error("not there");
    return std::make_unique<ShyCamera>();
  });
  std::vector<std::string> troubles;
  int taken = 0;
  const auto until = std::chrono::steady_clock::now() + slipd::testing::kPatience;
  while ((taken < 2 || troubles.size() < 2) && std::chrono::steady_clock::now() < until) {
    pollfd ready{pictures.fd(), POLLIN, 0};
    poll(&ready, 1, 1000);
    const auto news = pictures.take();
    if (!news.trouble.empty()) troubles.push_back(news.trouble);
    if (news.picture) ++taken;
  }
  EXPECT_THAT(troubles, ::testing::ElementsAre("not there", "gone"));
  EXPECT_GE(taken, 2);
}

TEST(PlayedVideo, gives_each_picture_when_it_is_due_and_then_none) {
  using std::chrono::steady_clock;
  const slipd::testing::TempFolder folder;
  const std::string file = folder.file("gel.avi").string();
  slipd::testing::write_video(file, std::vector<cv::Mat>(5, still_gel()), 50);
  PlayedVideo video(file, 1);
  std::vector<std::int64_t> times;
  while (const auto picture = video.next()) {
    EXPECT_LE(picture->time_ns, std::chrono::nanoseconds(steady_clock::now().time_since_epoch()).count());
    EXPECT_EQ(cv::norm(picture->brightness, still_gel(), cv::NORM_INF), 0);
    times.push_back(picture->time_ns);
  }
  ASSERT_EQ(times.size(), 5U);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_NEAR(1e-6 * (times[i] - times[i - 1]), 20, 1e-3);
}

TEST(PictureThread, plays_a_video_once_and_says_when_it_is_over) {
  const slipd::testing::TempFolder folder;
  const std::string file = folder.file("gel.avi").string();
  slipd::testing::write_video(file, std::vector<cv::Mat>(3, still_gel()), 50);
  PictureThread pictures([&] { return std::make_unique<PlayedVideo>(file, 1); });
  PictureThread::News news;
  while (news.trouble.empty()) {
    pollfd ready{pictures.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&ready, 1, std::chrono::milliseconds(slipd::testing::kPatience).count()), 1);
    news = pictures.take();
  }
  EXPECT_THAT(news.trouble, ::testing::HasSubstr("the video has ended"));
}

}  // namespace
}  // namespace slipd::camera
