#include "lab/coverage/measure.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "drivers/sim/options.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/frames/simulated_frames.hpp"

namespace lab {
namespace {

using slipd::sim::Phase;

constexpr double kLargestOffsetM = 1e-3;
constexpr std::uint64_t kOffsetStream = 0x6F6666, kHoldStream = 0x686F6C;

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

// One grasp whose phases `phase_of` names by the moment; those without a name do not count.
template <class PhaseOf>
Coverage play(GraspFrames& frames, const Estimator& estimator, const CoverageSetup& setup, std::size_t grasp,
              PhaseOf phase_of) {
  slipd::EstimatorChain chain = estimator.chain();
  Coverage found;
  drive(frames, chain,
        [&](const GraspSample& sample) {
          const std::string phase = phase_of(sample.at);
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
  return play(frames, estimator, setup, grasp, [&](const GraspMoment& at) { return names.at(at.move); });
}

Coverage play_history(const Estimator& estimator, const CoverageSetup& setup, std::size_t grasp) {
  const slipd::ChainSetup& chain = estimator.setup;
  RandomFrames frames(draw_grasp(chain.scene, setup.seed, grasp), chain.layout, chain.scene.skin,
                      {.noise = setup.noise, .frame_s = 1 / setup.rate_hz},
                      slipd::RandomStream(setup.seed).stream(grasp));
  return play(frames, estimator, setup, grasp, [](const GraspMoment& at) {
    const auto made = static_cast<Move>(at.move);
    return made == Move::unseen ? std::string() : std::string(name_of(made));
  });
}

// Gripped, loaded to a share of what friction holds, and held: nothing changes but noise.
Coverage play_hold(const Estimator& estimator, const CoverageSetup& setup, std::size_t grasp) {
  constexpr double kGrip_s = 0.1, kLoad_s = 0.3, kHold_s = 20, kLeastShare = 0.2, kMostShare = 0.7;
  const slipd::ChainSetup& chain = estimator.setup;
  const slipd::RandomStream random = slipd::RandomStream(setup.seed).stream(kHoldStream).stream(grasp);
  Grasp held = draw_grasp(chain.scene, setup.seed, grasp);
  const double normal_n = held.contact.normal_n, friction = held.contact.friction;
  const double shear_n = random.uniform(0, kLeastShare, kMostShare) * friction * normal_n;
  held.segments = {{Move::grip, normal_n, 0, friction, kGrip_s},
                   {Move::load, normal_n, shear_n, friction, kLoad_s},
                   {Move::hold, normal_n, shear_n, friction, kHold_s}};
  RandomFrames frames(std::move(held), chain.layout, chain.scene.skin,
                      {.noise = setup.noise, .frame_s = 1 / setup.rate_hz}, random.stream(0));
  return play(frames, estimator, setup, grasp, [](const GraspMoment& at) -> std::string {
    const double held_s = at.time_s - kGrip_s - kLoad_s;
    if (held_s < 0) return "0 loading";
    return held_s < 1 ? "1 first second" : held_s < 5 ? "2 until 5 s" : "3 until 20 s";
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

Coverage measure_holds(const Estimator& estimator, const CoverageSetup& setup, const Done& done) {
  return measure_all(estimator, setup, done, play_hold);
}

}  // namespace lab
