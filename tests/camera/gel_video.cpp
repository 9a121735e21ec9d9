// gel-video FILE: a rendered gel with dots at 25 pictures a second, in place of a camera. It rests for 2 s;
// an object is pressed on and pulled along for 1 s, held for 3 s, and slips out within 0.4 s; then the gel
// rests for 2 s.
#include <algorithm>
#include <cstdint>
#include <exception>
#include <iostream>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "tests/camera/rendered_gel.hpp"

namespace {

constexpr double kRateHz = 25;
constexpr float kDragPx = 10, kSpreadPx = 8;

// How far the gel is bent, 0 at rest to 1 while the object is held.
double bent_at(double seconds) {
  if (seconds < 6) return std::clamp(seconds - 2, 0.0, 1.0);
  return std::clamp(1 - (seconds - 6) / 0.4, 0.0, 1.0);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace slipd::testing;
  const std::span arguments(argv, static_cast<std::size_t>(argc));
  if (arguments.size() != 2) {
    std::cerr << "usage: gel-video FILE\n";
    return 2;
  }
  try {
    const RenderedGel gel;
    std::vector<cv::Mat> pictures;
    for (std::uint32_t i = 0; i < 8.4 * kRateHz; ++i) {
      const auto bent = static_cast<float>(bent_at(i / kRateHz));
      pictures.push_back(rendered(gel, press(gel, kDragPx * bent, 0, kSpreadPx * bent), i));
    }
    write_video(arguments[1], pictures, kRateHz);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "gel-video: " << error.what() << '\n';
    return 1;
  }
}
