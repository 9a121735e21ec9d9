// The family of frame generators: each plays one grasp of a known contact, frame by frame, in frame time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/contact/history.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

// What is true at a frame.
struct GraspMoment {
  std::uint64_t number = 0;  // of the frame, from 1
  double time_s = 0;         // since the grasp began
  std::size_t move = 0;      // what the gripper does: as the generator numbers its moves
  double normal_n = 0;       // normal force, N
  double shear_n = 0;        // tangential force, N; signed where its direction stays
  slipd::Truth truth;        // of the contact
};

// Not thread-safe.
class GraspFrames {
 public:
  GraspFrames() = default;
  GraspFrames(const GraspFrames&) = delete;
  GraspFrames& operator=(const GraspFrames&) = delete;
  virtual ~GraspFrames() = default;

  // The contact at the next frame; false at the grasp's end.
  virtual bool next() = 0;
  // What is true at this frame. Before next() has no value.
  const GraspMoment& moment() const noexcept { return moment_; }
  // The sensor's frame, at most once for each moment; it may be left out. May be changed. Valid until the
  // next call.
  virtual slipd::FrameSlot& sense() = 0;

  // What FrictionTrace needs: where the contact is, its loads, and the standard deviation of one taxel's
  // shear, Pa. Nulls where no such history makes the frames.
  struct Traced {
    const slipd::TaxelLayout* layout = nullptr;
    double x_m = 0, y_m = 0;
    const slipd::contact::LoadHistory* contact = nullptr;
    double shear_sigma_pa = 0;
  };
  virtual Traced traced() const { return {}; }

 protected:
  // What was sensed of this moment, as a frame.
  slipd::FrameSlot slot_of(slipd::TrialFrames& sensed, std::int64_t time_ns) const {
    slipd::FrameSlot slot;
    slot.sequence = moment_.number;
    slot.time_ns = time_ns;
    slot.truth = moment_.truth;
    slot.normal_pa = sensed.sensed_normal_pa();
    slot.shear_x_pa = sensed.sensed_shear_x_pa();
    slot.shear_y_pa = sensed.sensed_shear_y_pa();
    return slot;
  }

  GraspMoment moment_;
};

}  // namespace lab
