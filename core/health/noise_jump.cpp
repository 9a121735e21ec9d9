#include "core/health/noise_jump.hpp"

#include <algorithm>
#include <cstddef>

namespace slipd {

bool NoiseJump::update(const Channels& channels, bool in_contact) noexcept {
  if (!in_contact) {
    *this = {};
    return false;
  }
  std::size_t noisy = 0, quiet = 0;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const GroupChange& change = channels[c].change;
    const double step_pa2 = channels[c].step_square_pa2;
    const bool turns = static_cast<double>(change.turned) > kNoiseTurns * static_cast<double>(change.changed);
    if (step_pa2 <= kBeyondUsual * usual_pa2_[c]) {
      ++quiet;
    } else if (turns && usual_pa2_[c] > 0 && step_pa2 > kWrongScale * usual_pa2_[c]) {
      ++noisy;
    }
  }
  const bool jumped = frames_ >= learning_frames() && noisy == 1 && quiet == kChannels - 1;
  run_ = jumped ? run_ + 1 : 0;
  if (jumped) return run_ >= kSureFrames;
  ++frames_;
  const double gain = 1.0 / std::min<std::uint32_t>(frames_, kMemoryFrames);
  for (std::size_t c = 0; c < kChannels; ++c)
    usual_pa2_[c] += gain * (channels[c].step_square_pa2 - usual_pa2_[c]);
  return false;
}

}  // namespace slipd
