#include "lab/grip/trial.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>

#include "core/numeric/random.hpp"

namespace lab::grip {
namespace {

// The gripper: an order acts after its delay, and the force follows it as fast as this, N/s.
constexpr double kSlew = 300;
// An object that has moved so far is dropped, m.
constexpr double kDropped = 0.02;

class Fingers {
 public:
  Fingers(double delay_s, double step_s)
      : steps_(static_cast<std::size_t>(delay_s / step_s)), slew_(kSlew * step_s) {}
  double follow(double ordered_n) {
    orders_.push_back(ordered_n);
    if (orders_.size() <= steps_) return force_n_;
    force_n_ += std::clamp(orders_.front() - force_n_, -slew_, slew_);
    orders_.pop_front();
    return force_n_;
  }

 private:
  std::deque<double> orders_;
  std::size_t steps_;
  double slew_;
  double force_n_ = 0;
};

// Of a real sensor, uniform.
void add_noise(const Task& task, int step, double half_width_n, std::vector<float>& left,
               std::vector<float>& right) {
  const slipd::RandomStream frame = slipd::RandomStream(task.number).stream(static_cast<std::uint64_t>(step));
  const auto width = static_cast<float>(half_width_n);
  frame.stream(0).add_noise(left.data(), left.size(), width);
  frame.stream(1).add_noise(right.data(), right.size(), width);
}

double length_of(const std::array<double, 3>& v) {
  return std::hypot(v[0], v[1], v[2]);
}

// What is seen while an object is held.
class Witness {
 public:
  explicit Witness(const Task& task) : hold_from_s_(kLiftAt + task.lift_s) { result_.task = task; }

  void see(const World& world, double force_n) {
    const auto moved = world.moved_m();
    if (world.time_s() < kLiftAt) lifted_from_ = moved;
    const double way =
        length_of({moved[0] - lifted_from_[0], moved[1] - lifted_from_[1], moved[2] - lifted_from_[2]});
    result_.moved_m = std::max(result_.moved_m, way);
    result_.most_force_n = std::max(result_.most_force_n, force_n);
    if (world.time_s() < hold_from_s_) return;
    sum_n_ += force_n;
    ++steps_;
  }
  bool lost() const { return result_.moved_m > kDropped; }
  bool holds(double time_s) const { return time_s >= hold_from_s_; }
  TrialResult result() && {
    result_.dropped = lost();
    result_.mean_force_n = sum_n_ / std::max(1, steps_);
    return std::move(result_);
  }
  TrialResult& so_far() { return result_; }

 private:
  TrialResult result_;
  double hold_from_s_;
  std::array<double, 3> lifted_from_{};
  double sum_n_ = 0;
  int steps_ = 0;
};

// How soon slides are answered.
class Reactions {
 public:
  explicit Reactions(double most_n) : most_n_(most_n) {}

  // Once for each frame: whether all slides in it, and what was ordered before and in answer to it.
  void see(bool slides, double before_n, double ordered_n, TrialResult& result) {
    constexpr double kMoreN = 1e-6;
    if (slides && !sliding_) {
      sliding_ = true;
      waits_ = before_n < most_n_ - kMoreN;
      before_n_ = before_n;
      frames_ = 0;
      result.slides_unanswered += waits_ ? 0 : 1;
    }
    if (!sliding_) return;
    if (waits_ && ordered_n > before_n_ + kMoreN) {
      result.reactions_frames.push_back(frames_);
      waits_ = false;
    }
    ++frames_;
    if (slides) return;
    result.slides_unanswered += waits_ ? 1 : 0;
    sliding_ = waits_ = false;
  }

 private:
  double most_n_, before_n_ = 0;
  int frames_ = 0;
  bool sliding_ = false, waits_ = false;
};

Probe probe(const World& world, Bed& bed) {
  Probe probe{
      .time_s = world.time_s(), .truth = {}, .gamma = {}, .gamma_low = {}, .force_n = world.normal_n()};
  const slipd_estimate now = bed.estimate();
  if (const double gamma = slipd_margin(&now); !std::isnan(gamma)) {
    probe.gamma = gamma;
    if (std::isfinite(now.gamma_low)) probe.gamma_low = now.gamma_low;
  }
  return probe;
}

}  // namespace

TrialResult hold(const Task& task, const TrialOptions& options) {
  BedOptions bed_options = options.bed;
  bed_options.half_width_m = task.half_width_m;
  World world(task, options.world);
  Bed bed(bed_options);
  Witness witness(task);
  Fingers fingers(bed_options.delay_s, options.world.step_s);
  std::vector<float> left, right;
  const int steps_a_frame = static_cast<int>(std::lround(1 / (bed_options.rate_hz * options.world.step_s)));
  const double hold_s = kLiftAt + task.lift_s;
  Ordered ordered;
  Reactions reactions(bed_options.most_n);
  bool closed = false;
  int frames = 0, known = 0, probed = 0;
  std::vector<World::Moment> moments;  // their margins take longer than slipd waits for frames
  for (int step = 0; world.time_s() < task.length_s && !witness.lost(); ++step) {
    if (step % steps_a_frame == 0) {
      if (!closed && world.time_s() >= kCloseAt) {
        bed.order("close");
        closed = true;
      }
      world.read(Side::left, left);
      world.read(Side::right, right);
      add_noise(task, step, options.noise_n, left, right);
      const double before_n = ordered.force_n;
      ordered = bed.exchange(left, right, world.width_m());
      if (witness.holds(world.time_s()))
        reactions.see(world.slides(), before_n, ordered.force_n, witness.so_far());
      if (witness.holds(world.time_s())) {
        ++frames;
        const slipd_estimate now = bed.estimate();
        known += std::isnan(slipd_margin(&now)) ? 0 : 1;
        ++witness.so_far().states[slipd_state_name(now.state)];
      }
      if (options.verbose && step % (steps_a_frame * 40) == 0) {
        const slipd_estimate now = bed.estimate();
        const auto moved = world.moved_m();
        const auto load = task.load_n(world.time_s());
        std::printf(
            "%5.2f s ordered %6.2f N, acts %6.2f N, load %5.2f N, friction %.2f; slipd %s %s gamma %.2f low "
            "%.2f friction %.2f±%.2f; "
            "moved %.2f %.2f %.2f mm\n",
            world.time_s(), ordered.force_n, world.normal_n(), length_of(load),
            task.friction_at(world.time_s()), slipd_state_name(now.state), slipd_alert_name(now.alert),
            now.gamma, now.gamma_low, now.friction, now.friction_sigma, moved[0] * 1e3, moved[1] * 1e3,
            moved[2] * 1e3);
      }
    }
    const double wanted = ordered.order == "grip" ? ordered.force_n : ordered.order == "open" ? -5 : 0;
    const double force = fingers.follow(wanted);
    world.step(force, task.load_n(world.time_s()), task.friction_at(world.time_s()));
    witness.see(world, force);
    const double next_probe_s = hold_s + (probed + 0.5) * (task.length_s - hold_s) / options.probes;
    if (probed < options.probes && world.time_s() >= next_probe_s &&
        step % steps_a_frame == steps_a_frame - 1) {
      witness.so_far().probes.push_back(probe(world, bed));
      moments.push_back(world.moment());
      ++probed;
    }
  }
  for (std::size_t i = 0; i < moments.size(); ++i) {
    witness.so_far().probes[i].truth = world.true_margins(moments[i]);
  }
  witness.so_far().known_share = frames == 0 ? 0 : static_cast<double>(known) / frames;
  return std::move(witness).result();
}

TrialResult hold_deaf(const Task& task, double force_n, const TrialOptions& options) {
  World world(task, options.world);
  Witness witness(task);
  while (world.time_s() < task.length_s && !witness.lost()) {
    world.step(world.time_s() < kCloseAt ? 0 : force_n, task.load_n(world.time_s()),
               task.friction_at(world.time_s()));
    witness.see(world, force_n);
  }
  return std::move(witness).result();
}

}  // namespace lab::grip
