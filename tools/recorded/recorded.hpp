// A recording as a course in time: what was felt and estimated at each frame, and one whole frame. Any
// thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/storage/recording.hpp"

namespace slipd {

// One frame without its taxels. NaN: not known.
struct Moment {
  std::uint64_t sequence = 0;
  double time_s = 0;                 // since the first frame
  double normal_n = 0, shear_n = 0;  // sums over all taxels, the shear's of its resultant
  double truth_gamma = kUnknown;     // of a simulated sensor
  std::optional<RecordedEstimate> estimate;
};

struct Recorded {
  RecordingHeader header;
  std::vector<Moment> moments;
  std::size_t shown = 0;  // the moment whose frame is here
  std::vector<float> normal_pa, shear_x_pa, shear_y_pa;
  std::string fault;  // why it ends early; empty: it does not

  bool has_estimates() const noexcept;
  double seconds() const noexcept { return moments.empty() ? 0 : moments.back().time_s; }
};

// Reads all of it. The frame shown is the one nearest to `at_s`; without that the one of least margin, else
// of greatest normal force. Throws as RecordingReader does, and RecordingError for a recording without a
// frame.
Recorded read_recorded(const std::filesystem::path& file, std::optional<double> at_s);

}  // namespace slipd
