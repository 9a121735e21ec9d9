#include "lab/coverage/measure.hpp"

#include <cmath>
#include <vector>

#include "drivers/sim/options.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/frames/simulated_frames.hpp"

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

// The names of a cycle's phases: their number, and what they do.
std::vector<std::string> names_of(const std::vector<Phase>& cycle) {
  std::vector<std::string> names;
  double normal_n = 0, shear = 0;
  for (const Phase& phase : cycle) {
    const std::string number = std::to_string(names.size());
    names.push_back((number.size() < 2 ? "0" + number : number) + " " + kind_of(phase, normal_n, shear));
  }
  return names;
}

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

// One grasp whose phases `phase_of` names, by the number of the move; those without a name do not count.
template <class PhaseOf>
Coverage play(GraspFrames& frames, const Estimator& estimator, const CoverageSetup& setup, std::size_t grasp,
              PhaseOf phase_of) {
  slipd::EstimatorChain chain = estimator.chain();
  Coverage found;
  drive(frames, chain,
        [&](const GraspSample& sample) {
          const std::string phase = phase_of(sample.at.move);
          if (phase.empty() || !(sample.at.normal_n > 0)) return;
          found.add(phase, sample.estimate(), sample.at.truth, sample.traced);
          if (setup.watch) setup.watch({grasp, phase, sample});
        },
        {.trace = true});
  return found;
}

Coverage play_cycle(const Estimator& estimator, const CoverageSetup& setup, std::size_t grasp) {
  slipd::sim::SensorSettings settings = default_sensor(estimator.setup);
  const slipd::RandomStream random = slipd::RandomStream(setup.seed).stream(kOffsetStream).stream(grasp);
  settings.imperfections.seed = setup.seed * 1000 + grasp;
  if (grasp > 0) {
    settings.offset_x_m = kLargestOffsetM * (2 * random.uniform(0) - 1);
    settings.offset_y_m = kLargestOffsetM * (2 * random.uniform(1) - 1);
  }
  const std::vector<std::string> names = names_of(settings.cycle);
  SimulatedFrames frames(estimator.setup.layout, settings, setup.rate_hz);
  return play(frames, estimator, setup, grasp, [&](std::size_t phase) { return names.at(phase); });
}

Coverage play_history(const Estimator& estimator, const CoverageSetup& setup, std::size_t grasp) {
  const slipd::ChainSetup& chain = estimator.setup;
  RandomFrames frames(draw_grasp(chain.scene, setup.seed, grasp), chain.layout, chain.scene.skin,
                      {.noise = setup.noise, .frame_s = 1 / setup.rate_hz},
                      slipd::RandomStream(setup.seed).stream(grasp));
  return play(frames, estimator, setup, grasp, [](std::size_t move) {
    const auto made = static_cast<Move>(move);
    return made == Move::unseen ? std::string() : std::string(name_of(made));
  });
}

using Play = Coverage(const Estimator&, const CoverageSetup&, std::size_t);

Coverage measure_all(const Estimator& estimator, const CoverageSetup& setup, const Done& done, Play& play) {
  Coverage all;
  for (const Coverage& each : collect(setup.grasps, setup.watch ? 1 : setup.threads, done,
                                      [&](std::size_t i) { return play(estimator, setup, i); }))
    all.add(each);
  return all;
}

}  // namespace

void Coverage::add(const std::string& phase, const slipd::Estimate& estimate, const slipd::Truth& truth,
                   bool traced) {
  all.add(estimate, truth, traced);
  by_phase[phase].add(estimate, truth, traced);
}

void Coverage::add(const Coverage& other) {
  all.add(other.all);
  for (const auto& [phase, tally] : other.by_phase) by_phase[phase].add(tally);
}

Coverage measure_cycle(const Estimator& estimator, const CoverageSetup& setup, const Done& done) {
  return measure_all(estimator, setup, done, play_cycle);
}

Coverage measure_histories(const Estimator& estimator, const CoverageSetup& setup, const Done& done) {
  return measure_all(estimator, setup, done, play_history);
}

}  // namespace lab
