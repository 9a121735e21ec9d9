#include "tools/sliplab/faults/measure.hpp"

#include <algorithm>
#include <cmath>

#include "core/contact/history.hpp"
#include "tools/sliplab/parallel.hpp"

namespace sliplab {
namespace {

using namespace slipd;

constexpr std::uint64_t kFaultStream = 0x6661756C74;  // when a fault begins, apart from the noise
constexpr std::uint64_t kOtherGrasp = 0x10000000;     // numbers of the other finger's grasps
constexpr double kEarliest = 0.3, kLatest = 0.8;      // of the grasp

// What one chain said of one grasp, frame by frame.
struct Said {
  State state;
  Health health;
  float gamma;
  float truth;
};

std::uint64_t frames_of(const Grasp& grasp, double frame_s) {
  std::uint64_t frames = 0;
  for (const LoadSegment& segment : grasp.segments) {
    if (segment.move != Move::unseen)
      frames += static_cast<std::uint64_t>(std::ceil(segment.seconds / frame_s));
  }
  return frames;
}

// The other finger: a steady contact of another place, force and load.
struct OtherFinger {
  OtherFinger(const ChainSetup& chain, const FaultSetup& setup, std::size_t grasp)
      : drawn(draw_grasp(chain.scene, setup.seed, kOtherGrasp + grasp)),
        contact(contact::make_body_pair(
            contact::body_of(chain.scene.skin),
            {drawn.contact.radius_m, drawn.contact.modulus_pa, drawn.contact.poisson})),
        frames(chain.layout, setup.sensing.kind, setup.sensing.noise),
        random(RandomStream(setup.seed).stream(kOtherGrasp + grasp)) {
    const LoadSegment& loaded = drawn.segments.at(1);
    contact.move_to(loaded.normal_n, 0, loaded.friction);
    contact.move_to(loaded.normal_n, loaded.shear_n, loaded.friction);
    frames.feel(contact, drawn.contact.x_m, drawn.contact.y_m);
  }
  Frame sense(std::uint64_t sequence) {
    return frames.sense(drawn.direction_rad, random.stream(sequence), sequence);
  }

  Grasp drawn;
  contact::LoadHistory contact;
  TrialFrames frames;
  RandomStream random;
};

std::vector<Said> say(const ChainSetup& chain, const std::shared_ptr<const Model>& model,
                      const FaultSetup& setup, std::size_t grasp, Fault fault, std::uint64_t first) {
  EstimatorChain estimator(chain, model);
  const RandomStream draws = RandomStream(setup.seed).stream(grasp);
  FaultInjector injector(fault, chain.layout, first, draws.stream(kFaultStream));
  OtherFinger other(chain, setup, grasp);
  Sampling sensing = setup.sensing;
  sensing.spoil = [&](FrameSlot& frame) {
    if (fault == Fault::none) return;
    injector.spoil(frame, fault == Fault::other_finger && frame.sequence >= first
                              ? other.sense(frame.sequence)
                              : Frame{});
  };
  std::vector<Said> said;
  drive(
      draw_grasp(chain.scene, setup.seed, grasp), chain.layout, chain.scene.skin, sensing, draws, estimator,
      [&](const GraspSample& at) {
        if (at.move == Move::unseen) return;
        const double truth = fault == Fault::other_finger && said.size() + 1 >= first
                                 ? other.contact.safety_margin()
                                 : at.truth.gamma;
        said.push_back({at.estimate.state, at.estimate.health,
                        static_cast<float>(at.estimate.gamma.value_or(kUnknown)), static_cast<float>(truth)});
      });
  return said;
}

bool ok(const Said& at) {
  return at.state == State::ok;
}

bool too_safe(const Said& at) {
  return ok(at) && static_cast<double>(at.gamma - at.truth) > kGrossError;
}

struct Found {
  FaultLine sums;
  long after = -1;
};

Found compare(const std::vector<Said>& sound, const std::vector<Said>& spoilt, std::uint64_t first) {
  Found found;
  bool named = false;
  for (std::size_t i = 0; i < spoilt.size(); ++i) {
    found.sums.false_alarms += sound[i].health != Health::good ? 1 : 0;
    if (i + 1 < first) continue;
    const auto since = static_cast<long>(i + 1 - first);
    const bool bad = spoilt[i].health != Health::good;
    if (found.after < 0 && (bad || (ok(sound[i]) && !ok(spoilt[i])))) found.after = since;
    named = named || bad;
    if (since <= static_cast<long>(kGraceFrames)) continue;
    found.sums.answered += ok(spoilt[i]) ? 1 : 0;
    found.sums.too_safe += too_safe(spoilt[i]) ? 1 : 0;
    found.sums.sound_answered += ok(sound[i]) ? 1 : 0;
    found.sums.sound_too_safe += too_safe(sound[i]) ? 1 : 0;
  }
  found.sums.sound_frames = sound.size();
  found.sums.told = found.after >= 0 ? 1 : 0;
  found.sums.named = named ? 1 : 0;
  return found;
}

FaultLine together(Fault fault, const std::vector<Found>& grasps) {
  FaultLine line;
  line.fault = fault;
  line.grasps = grasps.size();
  std::vector<long> after;
  for (const Found& grasp : grasps) {
    line.told += grasp.sums.told;
    line.named += grasp.sums.named;
    line.answered += grasp.sums.answered;
    line.too_safe += grasp.sums.too_safe;
    line.sound_answered += grasp.sums.sound_answered;
    line.sound_too_safe += grasp.sums.sound_too_safe;
    line.false_alarms += grasp.sums.false_alarms;
    line.sound_frames += grasp.sums.sound_frames;
    if (grasp.after >= 0) after.push_back(grasp.after);
  }
  std::sort(after.begin(), after.end());
  if (!after.empty()) {
    line.median_frames = after[after.size() / 2];
    line.last_frames = after.back();
  }
  return line;
}

}  // namespace

std::vector<FaultLine> measure_faults(const ChainSetup& chain, const std::shared_ptr<const Model>& model,
                                      const std::vector<Fault>& faults, const FaultSetup& setup,
                                      const std::function<void(double)>& done) {
  std::vector<std::vector<Found>> found(faults.size(), std::vector<Found>(setup.grasps));
  for_each_index(
      setup.grasps, setup.threads,
      [&](std::size_t i) {
        const auto frames =
            static_cast<double>(frames_of(draw_grasp(chain.scene, setup.seed, i), setup.sensing.frame_s));
        const double at = RandomStream(setup.seed).stream(kFaultStream).uniform(i, kEarliest, kLatest);
        const auto first = static_cast<std::uint64_t>(at * frames) + 1;
        const auto sound = say(chain, model, setup, i, Fault::none, first);
        for (std::size_t f = 0; f < faults.size(); ++f)
          found[f][i] = compare(sound, say(chain, model, setup, i, faults[f], first), first);
      },
      [&](double share) {
        if (done) done(share);
      });
  std::vector<FaultLine> lines;
  for (std::size_t f = 0; f < faults.size(); ++f) lines.push_back(together(faults[f], found[f]));
  return lines;
}

}  // namespace sliplab
