#include "tools/recorded/recorded.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

FrameSummary summary_of(const FrameSlot& slot, const std::optional<RecordedEstimate>& estimate,
                        std::int64_t first_ns, double area_m2) {
  double normal = 0;
  double x = 0;
  double y = 0;
  for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
    normal += static_cast<double>(slot.normal_pa[i]);
    x += static_cast<double>(slot.shear_x_pa[i]);
    y += static_cast<double>(slot.shear_y_pa[i]);
  }
  return {.sequence = slot.sequence,
          .time_s = 1e-9 * static_cast<double>(slot.time_ns - first_ns),
          .normal_n = normal * area_m2,
          .shear_n = std::hypot(x, y) * area_m2,
          .truth_gamma = slot.truth.gamma,
          .estimate = estimate};
}

// The frame of the lowest rank is shown: any margin ranks before none.
double rank_of(const FrameSummary& frame, std::optional<double> at_s) {
  if (at_s) return std::fabs(frame.time_s - *at_s);
  if (frame.estimate && std::isfinite(frame.estimate->gamma)) return frame.estimate->gamma;
  return 2 + 1 / (1 + std::max(0.0, frame.normal_n));
}

}  // namespace

bool Recorded::has_estimates() const noexcept {
  return std::any_of(frames.begin(), frames.end(),
                     [](const FrameSummary& m) { return m.estimate.has_value(); });
}

Recorded read_recorded(const std::filesystem::path& file, std::optional<double> at_s) {
  RecordingReader reader(file);
  Recorded recorded{.header = reader.header(),
                    .frames = {},
                    .normal_pa = {},
                    .shear_x_pa = {},
                    .shear_y_pa = {},
                    .fault = {}};
  const std::size_t taxels = recorded.header.layout.size();
  std::vector<float> normal(taxels);
  std::vector<float> x(taxels);
  std::vector<float> y(taxels);
  FrameSlot slot;
  slot.normal_pa = normal;
  slot.shear_x_pa = x;
  slot.shear_y_pa = y;
  std::optional<RecordedEstimate> estimate;
  std::optional<std::int64_t> first_ns;
  double best = 0;
  while (reader.next_frame(slot, &estimate) == RecordingReader::Status::frame) {
    if (!first_ns) first_ns = slot.time_ns;
    recorded.frames.push_back(summary_of(slot, estimate, *first_ns, recorded.header.layout.area_m2()));
    const double rank = rank_of(recorded.frames.back(), at_s);
    if (recorded.frames.size() > 1 && !(rank < best)) continue;
    best = rank;
    recorded.shown = recorded.frames.size() - 1;
    recorded.normal_pa = normal;
    recorded.shear_x_pa = x;
    recorded.shear_y_pa = y;
  }
  recorded.fault = reader.fault();
  if (recorded.frames.empty()) {
    throw RecordingError(file.string() + ": a recording without a frame" +
                             (recorded.fault.empty() ? "" : "; " + recorded.fault),
                         0);
  }
  return recorded;
}

}  // namespace slipd
