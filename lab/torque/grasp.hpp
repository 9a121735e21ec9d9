// One contact under force and torque, felt by taxels frame by frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contact/scene_draws.hpp"
#include "core/contact/turning_contact.hpp"
#include "core/frame/frame.hpp"
#include "core/numeric/random.hpp"
#include "lab/torque/measure.hpp"

namespace lab {

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

class TurningGrasp {
 public:
  TurningGrasp(const slipd::ContactDraw& contact, const slipd::Skin& skin, const slipd::TaxelLayout& layout,
               double noise, const slipd::RandomStream& random);

  // Calls seen(frame, truth) for each frame of the move.
  template <class Seen>
  void play(const TurningMove& move, Seen seen) {
    const double from_n = normal_n_;
    const slipd::contact::PlaneLoad from = load_, to = load_of(move);
    for (std::size_t i = 1; i <= move.frames; ++i) {
      const double part = static_cast<double>(i) / static_cast<double>(move.frames);
      const auto at = [part](double a, double b) { return a + part * (b - a); };
      apply(at(from_n, move.normal_n), {at(from.shear_x_n, to.shear_x_n), at(from.shear_y_n, to.shear_y_n),
                                        at(from.torque_nm, to.torque_nm)});
      seen(feel(), truth());
    }
  }

 private:
  slipd::contact::PlaneLoad load_of(const TurningMove& move) const;
  void apply(double normal_n, const slipd::contact::PlaneLoad& load);
  slipd::Frame feel();
  slipd::Truth truth() const;

  const slipd::TaxelLayout& layout_;
  slipd::ContactDraw contact_;
  double noise_;
  slipd::RandomStream random_;
  slipd::contact::LoadHistory pull_;
  slipd::contact::TurningContact turning_;
  slipd::contact::LimitSurface hertz_;
  double normal_n_ = 0;
  slipd::contact::PlaneLoad load_;
  std::uint64_t sequence_ = 0;
  std::vector<float> normal_pa_, x_pa_, y_pa_, felt_normal_pa_, felt_x_pa_, felt_y_pa_;
};

}  // namespace lab
