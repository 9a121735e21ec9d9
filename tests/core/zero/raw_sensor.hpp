// A sensor without zeroing: every channel of every taxel has an offset of its own, noise and drift, and
// measures a contact.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/zero/bias_estimator.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd::test {

class RawSensor {
 public:
  static constexpr float kNoisePa = 200, kOffsetPa = 30000;

  explicit RawSensor(TaxelLayout layout, float noise_pa = kNoisePa, std::int64_t period_ns = 1'000'000,
                     std::uint64_t seed = 1)
      : noise_pa_(noise_pa),
        period_ns_(period_ns),
        maker_(std::move(layout)),
        random_(seed),
        memory_(3 * taxels()),
        drift_(3 * taxels()) {
    std::uniform_real_distribution<float> offset(-kOffsetPa, kOffsetPa);
    for (std::size_t i = 0; i < 3 * taxels(); ++i) offsets_.push_back(offset(random_));
    release();
  }

  std::size_t taxels() const { return maker_.layout().size(); }
  const TaxelLayout& layout() const { return maker_.layout(); }
  const std::vector<float>& offsets() const { return offsets_; }
  void without_offsets() { std::fill(offsets_.begin(), offsets_.end(), 0.0F); }
  void release() { sensed_.assign(3 * taxels(), 0.0F); }

  void press(double normal_n, double shear_n) {
    contact::LoadHistory contact(synthetic::paper_pair());
    contact.move_to(normal_n, 0, kFriction);
    contact.move_to(normal_n, shear_n, kFriction);
    const Frame frame = maker_.make(contact, 0, 0, 0, 0);
    sensed_.assign(frame.normal_pa.begin(), frame.normal_pa.end());
    sensed_.insert(sensed_.end(), frame.shear_x_pa.begin(), frame.shear_x_pa.end());
    sensed_.insert(sensed_.end(), frame.shear_y_pa.begin(), frame.shear_y_pa.end());
  }
  void press_everywhere(float pressure_pa, float shear_pa) {
    for (std::size_t i = 0; i < taxels(); ++i) {
      sensed_[i] = pressure_pa;
      sensed_[taxels() + i] = shear_pa;
    }
  }
  // From now on each offset drifts, by at most this.
  void drifts(float pa_per_s) {
    std::uniform_real_distribution<float> rate(-pa_per_s, pa_per_s);
    for (float& each : drift_) each = rate(random_) * 1e-9F * static_cast<float>(period_ns_);
  }

  void round_to(float step_pa) { step_pa_ = step_pa; }

  FrameSlot read() {
    std::normal_distribution<float> noise(0, 1);
    for (std::size_t i = 0; i < memory_.size(); ++i) {
      offsets_[i] += drift_[i];
      memory_[i] = offsets_[i] + sensed_[i] + noise_pa_ * noise(random_);
      if (step_pa_ > 0) memory_[i] = step_pa_ * std::round(memory_[i] / step_pa_);
    }
    FrameSlot slot;
    const std::span<float> all(memory_);
    slot.normal_pa = all.first(taxels());
    slot.shear_x_pa = all.subspan(taxels(), taxels());
    slot.shear_y_pa = all.last(taxels());
    slot.sequence = sequence_++;
    slot.time_ns = static_cast<std::int64_t>(slot.sequence) * period_ns_;
    return slot;
  }

  // Passes frames through the bias estimator for this long; returns the last frame.
  FrameSlot run(BiasEstimator& bias_estimator, double seconds) {
    FrameSlot slot;
    for (auto frames = static_cast<int>(seconds * 1e9 / static_cast<double>(period_ns_)); frames > 0;
         --frames) {
      slot = read();
      bias_estimator.apply(slot);
      bias_estimator.judge();
    }
    return slot;
  }

  // The largest error of the bias, Pa.
  float farthest(const BiasEstimator& bias_estimator) const {
    float most = 0;
    for (std::size_t i = 0; i < offsets_.size(); ++i)
      most = std::max(most, std::abs(bias_estimator.zero().bias_pa[i] - offsets_[i]));
    return most;
  }

 private:
  static constexpr double kFriction = 0.6;
  float noise_pa_, step_pa_ = 0;
  std::int64_t period_ns_;
  synthetic::FrameMaker maker_;
  std::mt19937_64 random_;
  std::vector<float> memory_, offsets_, drift_, sensed_;
  std::uint64_t sequence_ = 0;
};

}  // namespace slipd::test
