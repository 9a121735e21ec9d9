#include "lab/frames/simulated_frames.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace lab {
namespace {

using namespace slipd;

std::vector<std::int64_t> ends_of(const std::vector<sim::Phase>& cycle) {
  std::vector<std::int64_t> ends;
  ends.reserve(cycle.size());
  std::int64_t at_ns = 0;
  for (const sim::Phase& phase : cycle) ends.push_back(at_ns += phase.duration_ns);
  return ends;
}

}  // namespace

SimulatedFrames::SimulatedFrames(const TaxelLayout& layout, const sim::SensorSettings& settings,
                                 double rate_hz)
    : end_ns_(ends_of(settings.cycle)),
      period_(std::llround(1e9 / rate_hz)),
      offset_x_m_(settings.offset_x_m),
      offset_y_m_(settings.offset_y_m),
      shear_sigma_pa_(settings.imperfections.noise * settings.imperfections.full_scale_pa / std::sqrt(3.0)),
      sensor_(layout, settings),
      memory_(3 * layout.size()),
      last_(static_cast<std::uint64_t>((end_ns_.back() - 1) / period_.count())) {
  const std::span all(memory_);
  slot_.normal_pa = all.first(layout.size());
  slot_.shear_x_pa = all.subspan(layout.size(), layout.size());
  slot_.shear_y_pa = all.last(layout.size());
}

bool SimulatedFrames::next() {
  while (number_ < last_) {
    ++number_;
    sensor_.advance(period_);
    if (!sensor_.sample(slot_)) continue;
    const auto phase = std::lower_bound(end_ns_.begin(), end_ns_.end(), sensor_.elapsed().count());
    moment_ = {.number = moment_.number + 1,
               .time_s = 1e-9 * static_cast<double>(period_.count()) * static_cast<double>(number_),
               .move = static_cast<std::size_t>(phase - end_ns_.begin()),
               .normal_n = sensor_.load().normal_n(),
               .shear_n = sensor_.load().shear_n(),
               .truth = slot_.truth};
    return true;
  }
  return false;
}

GraspFrames::Traced SimulatedFrames::traced() const {
  if (sensor_.realistic() != nullptr) return {};
  return {&sensor_.layout(), offset_x_m_, offset_y_m_, &sensor_.load(), shear_sigma_pa_};
}

}  // namespace lab
