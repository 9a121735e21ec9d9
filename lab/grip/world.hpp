// A gripper of two fingers and an object, in the physics of MuJoCo. Each pad is a dome of pillars on springs,
// a contact of its own each; what slips and what sticks is decided by MuJoCo's contacts, and by no model of
// slipd.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "lab/grip/task.hpp"

namespace lab::grip {

struct WorldOptions {
  // Pillars of a pad along y and along z.
  int side = 5;
  // Between pillars, m.
  double pitch_m = 0.002;
  // Of the dome that the tips are on, m.
  double dome_radius_m = 0.04;
  // Of one pillar, N/m.
  double normal_stiffness = 1000, shear_stiffness = 600;
  // Step of the physics, s.
  double step_s = 0.002;
  // Iterations that take creep out of the friction; 0: MuJoCo's default.
  int noslip_iterations = 5;
};

enum class Side : std::uint8_t { left, right };

// The margins at a moment, until the object slides or turns: 1 - 1/s, with s the factor on its load, force
// and torque about the grip, at which it does, the fingers' force and friction staying. 0: does already; 1:
// no load.
struct TrueMargins {
  // Until all pillars slide.
  double until_sliding = 1;
  // Until at most one of each pad sticks, about which a load beside the grip turns the object.
  double until_turning = 1;
};

class World {
 public:
  // Throws std::runtime_error with MuJoCo's text.
  World(const Task& task, const WorldOptions& options = {});
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) = delete;

  // One step with these forces: of each finger, N; negative: opens. On the object; friction.
  void step(double grip_n, const std::array<double, 3>& load_n, double friction);

  double time_s() const;
  // What the pad's sensor reads, N: side x side taxels by rows from small y to large, x fastest; of each x, y
  // and z, pressing. Sensor x is along world y on the left finger and against it on the right one; sensor y
  // is up.
  void read(Side side, std::vector<float>& values) const;
  // Of the object from where it was when the simulation began, m.
  std::array<double, 3> moved_m() const;
  // Normal force of each finger's contacts, N: the mean of both.
  double normal_n() const;
  // Whether every contact of both pads slides.
  bool slides() const;
  // The opening between the pads, m.
  double width_m() const;

  struct State;
  // All that a step begins with.
  class Moment {
   public:
    ~Moment();
    Moment(Moment&&) noexcept;

   private:
    friend class World;
    explicit Moment(const State& state);
    struct Copy;
    std::unique_ptr<Copy> copy_;
  };
  Moment moment() const;

  TrueMargins true_margins(const Moment& moment) const;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace lab::grip
