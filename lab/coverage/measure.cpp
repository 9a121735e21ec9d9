#include "lab/coverage/measure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "drivers/sim/options.hpp"
#include "lab/histories/drive.hpp"
#include "lab/histories/friction_trace.hpp"
#include "tools/offline/parallel.hpp"

namespace lab {
namespace {

using slipd::sim::Phase;

constexpr double kLargestOffsetM = 1e-3;
constexpr std::uint64_t kOffsetStream = 0x6F6666;

// What a phase of the script does, after the load that the phase before left.
std::string kind_of(const Phase& phase, double& normal_n, double& shear) {
  const double was_normal_n = normal_n, was_shear = shear;
  if (phase.normal_n) normal_n = phase.normal_n->to;
  const auto& ramp = phase.load ? phase.load : phase.shear_n;
  if (ramp) shear = ramp->to;
  if (normal_n == 0) return was_normal_n > 0 ? "release" : "apart";
  if (was_normal_n == 0) return "press";
  if (normal_n > was_normal_n) return "regrip";
  if (phase.load && phase.load->to >= 1) return "slip";
  if (ramp && ramp->from * ramp->to < 0) return "reversal";
  if (ramp && std::fabs(ramp->to) < std::fabs(ramp->from)) return "unload";
  if (ramp) return "load";
  return phase.friction ? "friction" : shear == was_shear ? "hold" : "load";
}

// The names of a cycle's phases, and when each ends.
struct PhaseNames {
  explicit PhaseNames(const std::vector<Phase>& cycle) {
    double normal_n = 0, shear = 0;
    std::int64_t at_ns = 0;
    for (const Phase& phase : cycle) {
      at_ns += phase.duration_ns;
      const std::string number = std::to_string(names.size());
      names.push_back((number.size() < 2 ? "0" + number : number) + " " + kind_of(phase, normal_n, shear));
      end_ns.push_back(at_ns);
    }
  }
  const std::string& at(std::int64_t time_ns) const {
    const auto found = std::lower_bound(end_ns.begin(), end_ns.end(), time_ns);
    return names.at(std::min(static_cast<std::size_t>(found - end_ns.begin()), names.size() - 1));
  }
  std::vector<std::string> names;
  std::vector<std::int64_t> end_ns;
};

slipd::sim::SensorSettings default_sensor(const slipd::ChainSetup& chain) {
  const slipd::SensorSetup sensor{.name = "coverage",
                                  .layout = chain.layout,
                                  .rate_hz = 1000,
                                  .skin_radius_m = chain.scene.skin.radius_m,
                                  .skin_modulus_pa = chain.scene.skin.modulus_pa,
                                  .skin_poisson = chain.scene.skin.poisson,
                                  .profile = {},
                                  .device = nlohmann::json::object(),
                                  .options = nlohmann::json::object()};
  return slipd::sim::parse_options(sensor).sensor;
}

Coverage play_cycle(const slipd::ChainSetup& chain, const std::shared_ptr<const slipd::Model>& model,
                    const CoverageSetup& setup, std::size_t grasp) {
  slipd::sim::SensorSettings settings = default_sensor(chain);
  const slipd::RandomStream random = slipd::RandomStream(setup.seed).stream(kOffsetStream).stream(grasp);
  settings.imperfections.seed = setup.seed * 1000 + grasp;
  if (grasp > 0) {
    settings.offset_x_m = kLargestOffsetM * (2 * random.uniform(0) - 1);
    settings.offset_y_m = kLargestOffsetM * (2 * random.uniform(1) - 1);
  }
  const PhaseNames phases(settings.cycle);
  const double shear_sigma_pa =
      settings.imperfections.noise * settings.imperfections.full_scale_pa / std::sqrt(3.0);
  slipd::sim::SimulatedSensor sensor(chain.layout, settings);
  slipd::EstimatorChain estimator(chain, model);
  FrictionTrace trace(chain.layout, settings.offset_x_m, settings.offset_y_m);
  const std::size_t n = chain.layout.size();
  std::vector<float> normal(n), shear_x(n), shear_y(n);
  slipd::FrameSlot slot;
  slot.normal_pa = normal;
  slot.shear_x_pa = shear_x;
  slot.shear_y_pa = shear_y;
  const std::chrono::nanoseconds period(std::llround(1e9 / setup.rate_hz));
  Coverage found;
  while (sensor.elapsed().count() < phases.end_ns.back()) {
    sensor.advance(period);
    if (!sensor.sample(slot)) continue;
    const slipd::Estimate estimate =
        estimator.estimate({slot.sequence, slot.time_ns, normal, shear_x, shear_y});
    const bool traced = trace.update(sensor.load(), shear_sigma_pa);
    if (!(sensor.load().normal_n() > 0)) continue;
    const std::string& phase = phases.at(sensor.elapsed().count());
    found.add(phase, estimate, slot.truth.gamma, traced);
    if (setup.watch) {
      setup.watch({grasp, 1e-9 * static_cast<double>(slot.time_ns), phase, sensor.load().normal_n(),
                   sensor.load().shear_n(), slot.truth, traced, estimate});
    }
  }
  return found;
}

Coverage play_history(const slipd::ChainSetup& chain, const std::shared_ptr<const slipd::Model>& model,
                      const CoverageSetup& setup, std::size_t grasp) {
  slipd::EstimatorChain estimator(chain, model);
  Sampling sensing;
  sensing.noise = setup.noise;
  sensing.frame_s = 1 / setup.rate_hz;
  sensing.trace = true;
  Coverage found;
  drive(draw_grasp(chain.scene, setup.seed, grasp), chain.layout, chain.scene.skin, sensing,
        slipd::RandomStream(setup.seed).stream(grasp), estimator, [&](const GraspSample& at) {
          const std::string phase(name_of(at.move));
          if (at.move == Move::unseen) return;
          found.add(phase, at.estimate, at.truth.gamma, at.traced);
          if (setup.watch) {
            setup.watch({grasp, at.time_s, phase, at.normal_n, at.shear_n, at.truth, at.traced, at.estimate});
          }
        });
  return found;
}

template <class Play>
Coverage measure_all(const CoverageSetup& setup, const std::function<void(double)>& done, Play play) {
  std::vector<Coverage> found(setup.grasps);
  offline::for_each_index(
      setup.grasps, setup.watch ? 1 : setup.threads, [&](std::size_t i) { found[i] = play(i); },
      [&](double share) {
        if (done) done(share);
      });
  Coverage all;
  for (const Coverage& each : found) all.add(each);
  return all;
}

}  // namespace

void CoverageTally::add(const slipd::Estimate& estimate, double truth, bool traced) {
  ++frames_;
  if (estimate.state != slipd::State::ok || !estimate.gamma || !estimate.sigma) return;
  least_sigma_ = std::min(least_sigma_, *estimate.sigma);
  if (!traced) {
    ++untraced_;
    return;
  }
  ++ok_;
  const double over = *estimate.gamma - truth, error = std::fabs(over);
  error_ += error;
  worst_ = std::max(worst_, error);
  if (error <= 2 * *estimate.sigma) ++within_two_;
  if (error <= 3 * *estimate.sigma) ++within_three_;
  if (over > kTooSafe) ++too_safe_;
}

void CoverageTally::add(const CoverageTally& other) {
  frames_ += other.frames_;
  ok_ += other.ok_;
  untraced_ += other.untraced_;
  error_ += other.error_;
  within_two_ += other.within_two_;
  within_three_ += other.within_three_;
  too_safe_ += other.too_safe_;
  worst_ = std::max(worst_, other.worst_);
  least_sigma_ = std::min(least_sigma_, other.least_sigma_);
}

void Coverage::add(const std::string& phase, const slipd::Estimate& estimate, double truth, bool traced) {
  all.add(estimate, truth, traced);
  by_phase[phase].add(estimate, truth, traced);
}

void Coverage::add(const Coverage& other) {
  all.add(other.all);
  for (const auto& [phase, tally] : other.by_phase) by_phase[phase].add(tally);
}

Coverage measure_cycle(const slipd::ChainSetup& chain, const std::shared_ptr<const slipd::Model>& model,
                       const CoverageSetup& setup, const std::function<void(double)>& done) {
  return measure_all(setup, done, [&](std::size_t i) { return play_cycle(chain, model, setup, i); });
}

Coverage measure_histories(const slipd::ChainSetup& chain, const std::shared_ptr<const slipd::Model>& model,
                           const CoverageSetup& setup, const std::function<void(double)>& done) {
  return measure_all(setup, done, [&](std::size_t i) { return play_history(chain, model, setup, i); });
}

}  // namespace lab
