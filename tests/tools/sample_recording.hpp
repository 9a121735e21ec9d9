// A recording as the flight recorder would leave it: a press on 4 x 4 taxels, sheared until it slips.
#pragma once

#include <fcntl.h>

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "core/recording/recording.hpp"
#include "core/storage/unique_fd.hpp"

namespace slipctl::testing {

inline constexpr std::size_t kSampleFrames = 200;  // a hundred a second; the margin falls from 1 to 0

// `whole`: with all entries of estimates; otherwise as an older slipd left them.
inline void write_sample_recording(const std::filesystem::path& file, bool estimates, bool whole = true) {
  using namespace slipd;
  const UniqueFd fd(::open(file.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600));
  const RecordingHeader header{.sensor = "left",
                               .layout = TaxelLayout::grid(4, 4, 0.001),
                               .rate_hz = 100,
                               .simulated = true,
                               .description = "a sample"};
  RecordingWriter writer(fd.get(), header);
  std::vector<float> normal(16, 1e5F);  // 1.6 N in all
  std::vector<float> x(16);
  std::vector<float> y(16);
  FrameSlot slot;
  slot.normal_pa = normal;
  slot.shear_x_pa = x;
  slot.shear_y_pa = y;
  for (std::size_t i = 0; i < kSampleFrames; ++i) {
    const double load = static_cast<double>(i) / (kSampleFrames - 1);
    x.assign(16, static_cast<float>(0.5e5 * load));
    slot.sequence = 1000 + i;
    slot.time_ns = 5'000'000'000 + static_cast<std::int64_t>(i) * 10'000'000;
    slot.truth = {1 - load, 0.5};
    RecordedEstimate estimate{.state = 0,
                              .alert = static_cast<std::uint8_t>(load > 0.8   ? 2
                                                                 : load > 0.6 ? 1
                                                                              : 0),
                              .gamma = 1 - load,
                              .sigma = 0.02,
                              .friction = 0.5,
                              .normal_n = 1.6,
                              .shear_n = 0.8 * load,
                              // disturbed from 0.7 on, and then seen to slide
                              .sliding = static_cast<std::uint8_t>(load > 0.9   ? 2
                                                                   : load > 0.7 ? 1
                                                                                : 0),
                              .alert_cause = static_cast<std::uint8_t>(load > 0.9   ? 2
                                                                       : load > 0.6 ? 1
                                                                                    : 0)};
    if (whole) {
      estimate.gamma_low = 0.9 * estimate.gamma;
      estimate.shear_x_n = 0.75 * load;  // not the sum of the taxels, as of a contact's forces
      estimate.shear_y_n = 0.25 * load;
      estimate.center_x_m = 0.001;
      estimate.center_y_m = -0.002;
      estimate.torque_nm = 0;
      estimate.method = 3;
      estimate.health = 0;
    }
    if (writer.append(slot, estimates ? &estimate : nullptr)) throw std::runtime_error("cannot write");
  }
}

}  // namespace slipctl::testing
