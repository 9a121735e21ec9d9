// camera-bench [PICTURES]: what a processor takes for a camera's picture, from its JPEG bytes to the frame
// for slipd. Prints a line of CSV for each size: width, height, shrink, then the median of a picture, ms.
// Pictures are rendered and compressed beforehand.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "bridges/support/clock.hpp"
#include "camera/frames/gel_reader.hpp"
#include "camera/picture/raw_picture.hpp"
#include "tests/camera/rendered_gel.hpp"

namespace {

using namespace slipd;

constexpr int kPictures = 60;
constexpr double kPeriod = 20;  // pictures in which the gel is dragged there and back

struct Size {
  camera::PictureWish wish;
  double spacing_px;  // of the dots in the smaller picture
};

Size size_of(int width, int height, int shrink) {
  constexpr int kDotsAcross = 16;
  Size size{};
  size.wish.width = width;
  size.wish.height = height;
  size.wish.shrink = shrink;
  size.spacing_px = static_cast<double>(width) / shrink / kDotsAcross;
  return size;
}

using Bytes = std::vector<unsigned char>;

// A gel that an object drags to and fro, as a camera's JPEG pictures.
std::vector<Bytes> pictures_of(const Size& size, int count) {
  const auto& wish = size.wish;
  const testing::RenderedGel gel{
      .width = wish.width / wish.shrink, .height = wish.height / wish.shrink, .spacing = size.spacing_px};
  std::vector<Bytes> out;
  for (int i = 0; i < count; ++i) {
    const auto x = static_cast<float>(0.4 * size.spacing_px * std::sin(2 * M_PI * i / kPeriod));
    cv::Mat picture = testing::rendered(gel, testing::press(gel, x, 0, 0), static_cast<std::uint32_t>(i));
    if (wish.shrink > 1) cv::resize(picture, picture, {wish.width, wish.height}, 0, 0, cv::INTER_LINEAR);
    cv::imencode(".jpg", picture, out.emplace_back());
  }
  return out;
}

double median_ms(const Size& size, int count) {
  const auto pictures = pictures_of(size, count);
  constexpr double kMmPerPx = 0.05;
  camera::Profile profile;
  profile.picture = size.wish;
  profile.surface.mm_per_px = kMmPerPx;
  profile.nodes = {.rows = 7, .columns = 9, .pitch_mm = kMmPerPx * 1.5 * size.spacing_px};
  camera::GelReader reader(profile);
  std::vector<double> times;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto begun = bridges::clock_ns(CLOCK_PROCESS_CPUTIME_ID);
    camera::Decoded decoded = camera::decode(std::as_bytes(std::span(pictures[i])), size.wish, 0);
    camera::Picture picture;
    picture.brightness = decoded.brightness;
    picture.sequence = i + 1;
    const auto frame = reader.read(picture);
    times.push_back(1e-6 * static_cast<double>(bridges::clock_ns(CLOCK_PROCESS_CPUTIME_ID) - begun));
    if (frame.empty()) throw std::runtime_error("a picture gave no frame");
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

}  // namespace

int main(int argc, char** argv) {
  const std::span arguments(argv, static_cast<std::size_t>(argc));
  const int count = arguments.size() > 1 ? std::atoi(arguments[1]) : kPictures;
  const Size sizes[] = {size_of(320, 240, 1), size_of(640, 480, 1), size_of(3280, 2464, 8)};
  try {
    std::cout << "width,height,shrink,ms\n";
    for (const Size& size : sizes)
      std::cout << size.wish.width << ',' << size.wish.height << ',' << size.wish.shrink << ','
                << median_ms(size, std::max(1, count)) << std::endl;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "camera-bench: " << error.what() << '\n';
    return 1;
  }
}
