#include "tools/slipctl/calibration/reading.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace slipctl::calibration {
namespace {

constexpr std::size_t kParts = 10;
// Range of ten means of noise, in their standard deviations, that one course in ten thousand exceeds.
constexpr double kRangeOfChance = 6.5;

struct Course {
  double mean = 0, sigma = 0, range = 0, chance = 0;
};

// Noise is found from frame to frame, so that a slow motion is none.
Course course_of(std::span<const FrameSums> frames, std::size_t axis) {
  const auto value = [&](std::size_t i) { return frames[i].force_n[axis]; };
  std::array<double, kParts> parts{};
  const std::size_t each = frames.size() / kParts, used = each * kParts;
  double steps = 0;
  for (std::size_t i = 0; i < used; ++i) {
    parts[i / each] += value(i) / static_cast<double>(each);
    if (i > 0) steps += (value(i) - value(i - 1)) * (value(i) - value(i - 1));
  }
  Course out;
  for (const double part : parts) out.mean += part / kParts;
  for (const double part : parts) out.sigma += (part - out.mean) * (part - out.mean);
  out.sigma = std::sqrt(out.sigma / (kParts - 1) / kParts);
  const auto [least, greatest] = std::minmax_element(parts.begin(), parts.end());
  out.range = *greatest - *least;
  out.chance =
      kRangeOfChance * std::sqrt(steps / (2.0 * static_cast<double>(used - 1) * static_cast<double>(each)));
  return out;
}

}  // namespace

Reading reading_of(std::span<const FrameSums> frames) {
  if (frames.size() < kLeastFrames) throw std::invalid_argument("too few frames for a reading");
  Reading out{.frames = frames.size()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Course course = course_of(frames, axis);
    out.force_n[axis] = course.mean;
    out.sigma_n[axis] = course.sigma;
    out.range_n[axis] = course.range;
    out.chance_n[axis] = course.chance;
  }
  for (const FrameSums& frame : frames) {
    for (std::size_t axis = 0; axis < 2; ++axis)
      out.moment_nmm[axis] += frame.moment_nmm[axis] / static_cast<double>(frames.size());
  }
  return out;
}

nlohmann::json to_json(const Reading& reading) {
  return {{"force_n", reading.force_n},   {"sigma_n", reading.sigma_n},       {"range_n", reading.range_n},
          {"chance_n", reading.chance_n}, {"moment_nmm", reading.moment_nmm}, {"frames", reading.frames}};
}

Reading reading_from(const nlohmann::json& json) {
  Reading out;
  json.at("force_n").get_to(out.force_n);
  json.at("sigma_n").get_to(out.sigma_n);
  json.at("range_n").get_to(out.range_n);
  json.at("chance_n").get_to(out.chance_n);
  json.at("moment_nmm").get_to(out.moment_nmm);
  json.at("frames").get_to(out.frames);
  return out;
}

}  // namespace slipctl::calibration
