// A tactile sensor that is computed: script → contact with its load history → what taxels feel → what a real
// sensor would say of it, and the truth beside it. No clock, no thread, no socket: the driver, device
// simulators and tests each move its time on as they need.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/contact/hertz.hpp"
#include "core/contact/history.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "drivers/sim/imperfections.hpp"
#include "drivers/sim/script.hpp"

namespace slipd::sim {

struct SensorSettings {
  contact::Body skin{0.01, 0.5e6, 0.45};
  contact::Body object{std::numeric_limits<double>::infinity(), 2e11, 0.25};  // flat and stiff
  double offset_x_m = 0, offset_y_m = 0;                                      // where the contact's centre is
  std::vector<Phase> cycle;
  ImperfectionSettings imperfections;
};

class SimulatedSensor {
 public:
  // Throws contact::ContactError for bodies that have no Hertzian contact (both flat), std::invalid_argument
  // for a cycle without meaning. A layout of one taxel is one force vector for the
  // whole pad, wherever the contact lies.
  SimulatedSensor(TaxelLayout layout, const SensorSettings& settings);

  // What follows is for one thread, allocates nothing and does not throw.

  // Time goes on; the contact goes through every corner of the script on the way.
  void advance(std::chrono::nanoseconds by) noexcept;

  // A controller grips with this normal force (N, cut to 0 … 1000) instead of the script's; nothing: the
  // script again.
  void grip(std::optional<double> normal_n) noexcept;

  // The frame of this moment, the next in sequence. False: it was lost on the way and `out` is as it was.
  // `out`: spans of the layout's size; time_ns and device_time_ns count from the start.
  bool sample(FrameSlot& out) noexcept;

  // As if so many frames had been sampled, which nobody could take.
  void skip(std::uint64_t frames) noexcept { number_ += frames; }

  // How late the next frame will come.
  std::int64_t late_ns() const noexcept { return imperfections_.late_ns(number_); }

  std::chrono::nanoseconds elapsed() const noexcept { return std::chrono::nanoseconds(elapsed_ns_); }
  Truth truth() const noexcept;  // NaN without contact
  const contact::LoadHistory& load() const noexcept { return load_; }
  const Imperfections& imperfections() const noexcept { return imperfections_; }
  const TaxelLayout& layout() const noexcept { return layout_; }

 private:
  void meet(const Demand& demand) noexcept;
  void feel() noexcept;

  TaxelLayout layout_;
  bool one_vector_;
  double offset_x_m_, offset_y_m_;
  Script script_;
  contact::LoadHistory load_;
  Imperfections imperfections_;
  std::optional<double> grip_n_;
  std::int64_t elapsed_ns_ = 0;
  std::uint64_t number_ = 0;
  std::vector<float> normal_pa_, shear_pa_;  // what the taxels feel, kept while nothing moves
  bool moved_ = true;
};

}  // namespace slipd::sim
