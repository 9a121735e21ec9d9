// A recording as a time series: forces and estimate of each frame, and one whole frame. Any thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/recording/recording.hpp"

namespace slipd {

// One frame without its taxels. NaN: unknown.
struct FrameSummary {
  std::uint64_t sequence = 0;                // of the frame
  double time_s = 0;                         // since the first frame
  double normal_n = 0;                       // normal force, N
  double shear_n = 0;                        // magnitude of the tangential force, N
  double truth_gamma = kUnknown;             // true margin of a simulated sensor
  std::optional<RecordedEstimate> estimate;  // absent: the recording has none for this frame
};

struct Recorded {
  RecordingHeader header;
  std::vector<FrameSummary> frames;  // all of them, in order
  std::size_t shown = 0;             // index of the frame whose taxels are below
  std::vector<float> normal_pa;      // pressure, Pa, one element per taxel
  std::vector<float> shear_x_pa;     // traction along x, Pa
  std::vector<float> shear_y_pa;     // traction along y, Pa
  std::string fault;                 // what is missing of the recording; empty: it is complete

  bool has_estimates() const noexcept;
  double seconds() const noexcept { return frames.empty() ? 0 : frames.back().time_s; }
};

// Reads the whole file. The frame shown is the one nearest to `at_s`; without `at_s` that of least margin, or
// of greatest normal force where no margin is known. Throws as RecordingReader does, and RecordingError for a
// recording without a frame.
Recorded read_recorded(const std::filesystem::path& file, std::optional<double> at_s);

}  // namespace slipd
