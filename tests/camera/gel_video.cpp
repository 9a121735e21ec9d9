// gel-video FILE [--width PX] [--height PX] [--rate-hz HZ]: a rendered gel with dots, in place of a camera.
// It rests for 2 s; an object is pressed on and pulled along for 1 s, held for 3 s, and slips out within 0.4
// s; then the gel rests for 2 s.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <exception>
#include <iostream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/camera/rendered_gel.hpp"

namespace {

using namespace slipd::testing;

// How far the gel is bent, 0 at rest to 1 while the object is held.
double bent_at(double seconds) {
  if (seconds < 6) return std::clamp(seconds - 2, 0.0, 1.0);
  return std::clamp(1 - (seconds - 6) / 0.4, 0.0, 1.0);
}

std::vector<cv::Mat> pictures_of(const RenderedGel& gel, double rate_hz) {
  constexpr double kSeconds = 8.4;
  const double drag_px = 0.5 * gel.spacing, spread_px = 0.4 * gel.spacing;
  std::vector<cv::Mat> pictures;
  for (std::uint32_t i = 0; i < kSeconds * rate_hz; ++i) {
    const double bent = bent_at(i / rate_hz);
    const auto press_now =
        press(gel, static_cast<float>(drag_px * bent), 0, static_cast<float>(spread_px * bent));
    pictures.push_back(rendered(gel, press_now, i));
  }
  return pictures;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Renders a video of a gel with dots, from which an object slips"};
  RenderedGel gel;
  std::string file;
  double rate_hz = 25;
  app.add_option("file", file, "where to write it")->required();
  app.add_option("--width", gel.width, "px; dots are a sixteenth of it apart")->check(CLI::Range(64, 4096));
  app.add_option("--height", gel.height, "px")->check(CLI::Range(64, 4096));
  app.add_option("--rate-hz", rate_hz, "pictures a second")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  gel.spacing = gel.width / 16.0;
  gel.radius = gel.width / 128.0;
  try {
    write_video(file, pictures_of(gel, rate_hz), rate_hz);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "gel-video: " << error.what() << '\n';
    return 1;
  }
}
