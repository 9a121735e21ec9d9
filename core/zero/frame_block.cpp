#include "core/zero/frame_block.hpp"

#include <algorithm>

namespace slipd {

FrameBlock::FrameBlock(std::size_t taxels)
    : first_(3 * taxels), sum_(3 * taxels), squares_(3 * taxels), mean_(3 * taxels), variance_(3 * taxels) {}

bool FrameBlock::add(const FrameSlot& frame) noexcept {
  const std::span<float> channels[] = {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa};
  float *first = first_.data(), *sum = sum_.data(), *squares = squares_.data();
  for (const auto& channel : channels) {
    const float* const raw = channel.data();
    const std::size_t taxels = channel.size();
    if (count_ == 0) {
      std::copy_n(raw, taxels, first);
      std::fill_n(sum, taxels, 0.0F);
      std::fill_n(squares, taxels, 0.0F);
    } else {
#pragma omp simd
      for (std::size_t i = 0; i < taxels; ++i) {
        const float off = raw[i] - first[i];
        sum[i] += off;
        squares[i] += off * off;
      }
    }
    first += taxels;
    sum += taxels;
    squares += taxels;
  }
  if (count_ == 0) first_ns_ = frame.time_ns;
  last_ns_ = frame.time_ns;
  if (++count_ < kFrames || last_ns_ - first_ns_ < kDurationNs) return false;
  finish();
  return true;
}

bool FrameBlock::newest_mean(std::span<float> mean_pa) const noexcept {
  if (count_ == 0 && frames_ == 0) return false;
  for (std::size_t i = 0; i < mean_pa.size(); ++i)
    mean_pa[i] = count_ > 0 ? first_[i] + sum_[i] / static_cast<float>(count_) : mean_[i];
  return true;
}

void FrameBlock::finish() noexcept {
  const auto n = static_cast<float>(count_);
  const std::size_t size = mean_.size();
  const float *first = first_.data(), *sum = sum_.data(), *squares = squares_.data();
  float *mean = mean_.data(), *variance = variance_.data();
#pragma omp simd
  for (std::size_t i = 0; i < size; ++i) {
    const float off = sum[i] / n;
    const float spread = (squares[i] - sum[i] * off) / (n - 1);
    mean[i] = first[i] + off;
    variance[i] = spread > 0 ? spread : 0;
  }
  frames_ = count_;
  begun_ns_ = first_ns_;
  ended_ns_ = last_ns_;
  count_ = 0;
}

}  // namespace slipd
