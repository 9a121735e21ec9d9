// One contact under force and torque, sensed by taxels frame by frame.
#pragma once

#include <cstdint>
#include <vector>

#include "core/contact/scene_draws.hpp"
#include "core/contact/turning_contact.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/numeric/random.hpp"
#include "lab/frames/grasp_frames.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

// What a contact carries: a pull alone, both, or a torque with little pull.
enum class Mix : std::uint8_t { pull, both, turn };
// How it came to that.
enum class Course : std::uint8_t {
  frame,    // one frame of a load that rose in a straight line, without tracking
  ramp,     // a grip that closes, then such a load up to slip, with tracking
  history,  // then loads that turn, fall, reverse, and a grip that changes
};
const char* name_of(Mix mix) noexcept;
const char* name_of(Course course) noexcept;

// A load as a share of what friction holds of its mixture.
struct MixedLoad {
  double share = 0;       // 0 … 1
  double mix_rad = 0;     // 0: a pull; pi/2: a torque
  double toward_rad = 0;  // of the pull
};

// A straight move in so many frames.
struct TurningMove {
  std::size_t frames = 1;
  double normal_n = 0;
  MixedLoad load;
};

// The moves of grasp number `index` after it was drawn as `contact`. A course of one frame has one move.
std::vector<TurningMove> draw_moves(const slipd::ContactDraw& contact, Course course, Mix mix,
                                    const slipd::RandomStream& random);

// Moves are numbered from 0; the moment's shear force is its magnitude.
class TorqueFrames final : public GraspFrames {
 public:
  // `layout` must outlive this object. noise: half-width of sensor noise, a fraction of the frame's largest
  // pressure.
  TorqueFrames(const slipd::ContactDraw& contact, const slipd::Skin& skin, const slipd::TaxelLayout& layout,
               double noise, const slipd::RandomStream& random, std::vector<TurningMove> moves);

  bool next() override;
  slipd::FrameSlot& sense() override;

 private:
  slipd::contact::PlaneLoad load_of(const TurningMove& move) const;
  void apply(double normal_n, const slipd::contact::PlaneLoad& load);
  void fill_taxels();

  const slipd::TaxelLayout& layout_;
  slipd::ContactDraw contact_;
  slipd::RandomStream random_;
  std::vector<TurningMove> moves_;
  slipd::contact::LoadHistory pull_;
  slipd::contact::TurningContact turning_;
  slipd::contact::LimitSurface hertz_;
  slipd::TrialFrames frames_;
  slipd::FrameSlot slot_;
  std::size_t begun_ = 0;                       // moves
  std::size_t step_ = 0, steps_ = 0;            // of the move
  double from_normal_n_ = 0;                    // at its begin
  slipd::contact::PlaneLoad from_, to_, load_;  // at its begin, at its end, now
};

}  // namespace lab
