// The frames of a random grasp: contact with its load history → taxels → noise.
#pragma once

#include <cstdint>
#include <optional>

#include "core/contact/contact_field.hpp"
#include "core/contact/history.hpp"
#include "core/frame/layout.hpp"
#include "core/numeric/random.hpp"
#include "lab/frames/grasp_frames.hpp"
#include "lab/frames/random_grasp.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

struct Sampling {
  slipd::NoiseKind kind = slipd::NoiseKind::sensor;  // what the noise is a fraction of
  double noise = 0.01;                               // half-width, a fraction of the frame's largest pressure
  double frame_s = 0.005;                            // time from frame to frame, s
  double stretch = 1, power = 2;                     // the contact's shape, see contact::ContactGeometry
};

// Moves are numbered as in Move. Only contacts at the surface and of round shape can be traced.
class RandomFrames final : public GraspFrames {
 public:
  // `layout` must outlive this object. `skin`: of the sensor; its depth_m is what is sensed. `noise`: each
  // frame takes the stream of its number.
  RandomFrames(Grasp grasp, const slipd::TaxelLayout& layout, const slipd::Skin& skin,
               const Sampling& sampling, const slipd::RandomStream& noise);

  bool next() override;
  slipd::FrameSlot& sense() override;
  Traced traced() const override;

  std::uint64_t length() const noexcept;  // frames of the grasp

 private:
  const slipd::TaxelLayout& layout_;
  Grasp grasp_;
  Sampling sampling_;
  slipd::RandomStream noise_;
  slipd::contact::LoadHistory contact_;
  slipd::TrialFrames frames_;
  std::optional<slipd::contact::ContactField> field_;
  slipd::FrameSlot slot_;
  std::size_t begun_ = 0;  // segments
  int step_ = 0, steps_ = 0;
  double from_normal_n_ = 0, from_shear_n_ = 0;  // at the segment's begin
};

}  // namespace lab
