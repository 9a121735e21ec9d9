// Slides of grasps on gels through slipd's chain: when they are told, and what is told where none is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lab/collect.hpp"
#include "lab/gels/gel_frames.hpp"
#include "lab/tally/samples.hpp"

namespace lab {

struct GelSetup {
  std::size_t grasps = 200;  // of each course
  double rate_hz = 25;       // pictures
  double noise_px = 0.05;    // of the field, standard deviation of each axis
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

// Of the grasps of one course. A slide is told by the first alert `slip` from a second before it on; alerts
// before that, or of a grasp that does not slide, are false.
struct GelLine {
  GelCourse course = GelCourse::held;
  std::size_t grasps = 0, alarmed = 0;  // alarmed: with a false alert
  double held_s = 0;                    // in contact, without a slide
  std::size_t false_alerts = 0;
  // Of slides:
  std::size_t before = 0;           // told in the second before
  std::size_t soon = 0;             // then, or at most kSoonPictures after it
  std::size_t soon_after_loss = 0;  // those, or at most so many after the contact was lost
  std::size_t told = 0;
  Samples after_s;  // of those that were told, from the beginning of the slide, s

  static constexpr double kSoonPictures = 2;
  void add(const GelLine& other);
};

std::vector<GelLine> measure_gels(const GelSetup& setup, const Done& done);

}  // namespace lab
