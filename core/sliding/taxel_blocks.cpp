#include "core/sliding/taxel_blocks.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/pause.hpp"

namespace slipd {
namespace {

// Timers jitter: a frame this much early still completes a block.
constexpr std::int64_t kJitterNs = 1'000'000;
constexpr double kSecondsPerNs = 1e-9;
// Time in which the noise of the quietest block is forgotten by half, blocks.
constexpr double kQuietBlocks = 2400;
// Variance of a value that is rounded to steps, over the square of a step.
constexpr double kRoundingVariance = 1.0 / 12;

std::int64_t ns_of_s(double seconds) noexcept {
  return static_cast<std::int64_t>(seconds * 1e9);
}

// The cell of a place among `cells` between `low` and `high`.
std::size_t cell_at(double place, double low, double high, std::size_t cells) noexcept {
  const double share = high > low ? (place - low) / (high - low) : 0;
  return std::min(cells - 1, static_cast<std::size_t>(share * static_cast<double>(cells)));
}

}  // namespace

TaxelBlocks::TaxelBlocks(const TaxelLayout& layout, const TaxelBlockOptions& options)
    : options_(options), taxels_(layout.size()), cells_(layout.size()) {
  const std::size_t side = options.cells_per_side;
  x_m_.assign(layout.x_m().begin(), layout.x_m().end());
  y_m_.assign(layout.y_m().begin(), layout.y_m().end());
  if (taxels_ > side * side) {
    const auto [left, right] = std::minmax_element(x_m_.begin(), x_m_.end());
    const auto [bottom, top] = std::minmax_element(y_m_.begin(), y_m_.end());
    cells_ = side * side;
    std::vector<double> x(cells_), y(cells_), count(cells_);
    cell_of_.resize(taxels_);
    for (std::size_t i = 0; i < taxels_; ++i) {
      const std::size_t cell =
          cell_at(y_m_[i], *bottom, *top, side) * side + cell_at(x_m_[i], *left, *right, side);
      cell_of_[i] = static_cast<std::uint16_t>(cell);
      x[cell] += x_m_[i];
      y[cell] += y_m_[i];
      count[cell] += 1;
    }
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      x[cell] /= std::max(1.0, count[cell]);
      y[cell] /= std::max(1.0, count[cell]);
    }
    x_m_ = std::move(x);
    y_m_ = std::move(y);
  }
  frame_.resize(3 * cells_);
  last_frame_.resize(3 * cells_);
  sums_.resize(3 * cells_);
  blocks_.resize(kKept * 3 * cells_);
}

void TaxelBlocks::forget() noexcept {
  size_ = frames_ = differences_ = 0;
  squares_ = spacing_s_ = 0;
  has_last_ = false;
}

const float* TaxelBlocks::block(std::size_t ago) const noexcept {
  return blocks_.data() + 3 * cells_ * ((newest_ + kKept - ago) % kKept);
}

double TaxelBlocks::noise() const noexcept {
  return std::sqrt(std::max(frame_variance_, kRoundingVariance * step_ * step_) / block_frames_);
}

bool TaxelBlocks::add(const Frame& frame) noexcept {
  const bool goes_on = frame.time_ns >= last_ns_ && frame.time_ns - last_ns_ <= ns_of_s(kPause_s);
  if ((frames_ > 0 || size_ > 0) && !goes_on) forget();
  const bool alone = block_frames_ == 1 && size_ > 0 && spans_block(frame.time_ns - last_ns_);
  last_ns_ = frame.time_ns;
  bool completed = false;
  if (frames_ > 0 && spans_block(frame.time_ns - started_ns_)) {
    complete();
    completed = true;
  }
  const bool pooled = !cell_of_.empty();
  if (frames_ > 0 && pooled &&
      frame.time_ns - pooled_ns_ < ns_of_s(kBlock_s / options_.pooled_frames) - kJitterNs)
    return completed;
  if (frames_ == 0) {
    if (size_ > 0) spacing_s_ = static_cast<double>(frame.time_ns - started_ns_) * kSecondsPerNs;
    started_ns_ = frame.time_ns;
    std::fill(sums_.begin(), sums_.end(), 0.0);
  }
  pooled_ns_ = frame.time_ns;
  pool(frame);
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += static_cast<double>(frame_[i]);
  measure_noise();
  ++frames_;
  if (!alone) return completed;
  complete();
  return true;
}

bool TaxelBlocks::spans_block(std::int64_t passed_ns) const noexcept {
  return passed_ns >= ns_of_s(kBlock_s) - kJitterNs;
}

std::size_t TaxelBlocks::blocks_in(std::size_t blocks) const noexcept {
  const double span_s = static_cast<double>(blocks) * kBlock_s;
  return std::max<std::size_t>(
      2, static_cast<std::size_t>(std::lround(span_s / std::max(kBlock_s, spacing_s_))));
}

void TaxelBlocks::pool(const Frame& frame) noexcept {
  float* out = frame_.data();
  for (const auto& channel : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa}) {
    if (cell_of_.empty()) {
      std::copy(channel.begin(), channel.end(), out);
    } else {
      std::fill_n(out, cells_, 0.0F);
      const float* const values = channel.data();
      for (std::size_t i = 0; i < taxels_; ++i) out[cell_of_[i]] += values[i];
    }
    out += cells_;
  }
}

void TaxelBlocks::measure_noise() noexcept {
  if (has_last_) {
    double squares = 0;
    for (std::size_t i = 0; i < frame_.size(); ++i) {
      const double difference = std::fabs(static_cast<double>(frame_[i] - last_frame_[i]));
      squares += difference * difference;
      if (difference > 0 && (step_ == 0 || difference < step_)) step_ = difference;
    }
    squares_ += squares / static_cast<double>(frame_.size());
    ++differences_;
  }
  std::swap(frame_, last_frame_);
  has_last_ = true;
}

void TaxelBlocks::complete() noexcept {
  newest_ = (newest_ + 1) % kKept;
  size_ = std::min(size_ + 1, kKept);
  block_frames_ = static_cast<double>(frames_);
  float* out = blocks_.data() + 3 * cells_ * newest_;
  for (std::size_t i = 0; i < sums_.size(); ++i) out[i] = static_cast<float>(sums_[i] / block_frames_);
  if (differences_ > 0) {
    const double variance = squares_ / static_cast<double>(2 * differences_);
    const double grown = frame_variance_ * (1 + 1 / kQuietBlocks);
    frame_variance_ = frame_variance_ > 0 ? std::min(grown, variance) : variance;
  }
  frames_ = differences_ = 0;
  squares_ = 0;
}

}  // namespace slipd
