// Random grasps of a simulated sensor with one preset: holds and slips, and what the chain raised in each.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/chain/chain.hpp"
#include "drivers/sim/simulated_sensor.hpp"

namespace lab {

enum class GraspKind : std::uint8_t {
  hold,  // gripped, loaded to at most 0.4 of what holds, in half of them gripped harder and loaded anew
  slip   // gripped, held, loaded until it slides, and 0.5 s longer
};

// A sensor that a preset is made for.
struct PresetBench {
  slipd::sim::Preset preset;
  slipd::TaxelLayout layout;
  slipd::Skin skin;
  double rate_hz;
};
PresetBench bench_of(slipd::sim::Preset preset);

// The chain of a scene with friction from 0.3 to 1. `friction`: known beforehand; none: it is not.
slipd::ChainSetup chain_of(const PresetBench& bench, std::optional<double> friction);

// The grasp `index` of its kind: normal force 2–8 N, friction 0.3–1, closing in 50–150 ms, held for 0.5–1.5
// s, loaded in 50 ms–2 s.
slipd::sim::SensorSettings draw_preset_grasp(const PresetBench& bench, GraspKind kind, std::uint64_t seed,
                                             std::size_t index);

// The frames that a preset's sensor gives of one grasp, at the bench's rate.
class PresetFrames {
 public:
  PresetFrames(const PresetBench& bench, const slipd::sim::SensorSettings& grasp);
  // `slot_` points into `memory_`.
  PresetFrames(const PresetFrames&) = delete;
  PresetFrames& operator=(const PresetFrames&) = delete;

  bool next();  // the next frame; false at the grasp's end
  const slipd::FrameSlot& frame() const noexcept { return slot_; }
  double time_s() const noexcept;  // of that frame, since the grasp began
  const slipd::sim::SimulatedSensor& sensor() const noexcept { return sensor_; }
  std::uint64_t length() const noexcept { return last_; }  // frames of the grasp

 private:
  std::chrono::nanoseconds period_;
  slipd::sim::SimulatedSensor sensor_;
  std::vector<float> memory_;
  slipd::FrameSlot slot_;
  std::uint64_t number_ = 0, last_;
};

// What was raised in one grasp; times in s since it began.
struct AlertTrial {
  std::optional<double> gross_slip_s;   // when the true margin reached 0
  std::optional<double> first_alert_s;  // of any level
  std::optional<double> first_slip_s;   // of level slip
  std::optional<double> slid_m;  // how far the object had slid at the first alert, m; preset ideal: none
  slipd::AlertCause cause = slipd::AlertCause::none;  // of the first alert
  double least_margin = 1;                            // true, over all frames in contact
  std::size_t contact_frames = 0;                     // with a true margin
  std::size_t answered_frames = 0;                    // of these, with a margin from the chain
};

// One grasp through two chains: with the friction that this contact slides at, and without it.
struct AlertTrialPair {
  AlertTrial known, unknown;
};
AlertTrialPair run_preset_grasp(const PresetBench& bench, const slipd::sim::SensorSettings& grasp);

}  // namespace lab
