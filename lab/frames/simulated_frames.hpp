// The frames of the simulator that the driver `sim` plays: one cycle of its script.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "drivers/sim/simulated_sensor.hpp"
#include "lab/frames/grasp_frames.hpp"
#include "lab/frames/preset_grasp.hpp"

namespace lab {

// Moves are the phases of the cycle. Loads and traces are those of preset `ideal`; with any other they are 0
// and there is none. Frames that the sensor loses do not come.
class SimulatedFrames final : public GraspFrames {
 public:
  SimulatedFrames(const slipd::TaxelLayout& layout, const slipd::sim::SensorSettings& settings,
                  double rate_hz);
  // A grasp of a preset's sensor, at its rate.
  SimulatedFrames(const PresetBench& bench, const slipd::sim::SensorSettings& grasp)
      : SimulatedFrames(bench.layout, grasp, bench.rate_hz) {}

  bool next() override;
  slipd::FrameSlot& sense() override { return slot_; }
  Traced traced() const override;

  const slipd::sim::SimulatedSensor& sensor() const noexcept { return sensor_; }
  std::uint64_t length() const noexcept { return last_; }  // frames of the cycle

 private:
  std::vector<std::int64_t> end_ns_;  // of each phase
  std::chrono::nanoseconds period_;
  double offset_x_m_, offset_y_m_, shear_sigma_pa_;
  slipd::sim::SimulatedSensor sensor_;
  std::vector<float> memory_;
  slipd::FrameSlot slot_;
  std::uint64_t number_ = 0, last_;  // of the sensor's frames, lost ones too
};

}  // namespace lab
