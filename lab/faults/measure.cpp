#include "lab/faults/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/contact/history.hpp"
#include "core/frame/frame.hpp"
#include "core/numeric/random.hpp"
#include "lab/frames/random_frames.hpp"
#include "lab/frames/simulated_frames.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr std::uint64_t kFaultStream = 0x6661756C74;  // when a fault begins, apart from the noise
constexpr std::uint64_t kOtherGrasp = 0x10000000;     // numbers of the other finger's grasps
constexpr double kEarliest = 0.3, kLatest = 0.8;      // of the grasp

// What one chain said of one grasp, frame by frame.
struct Answer {
  State state;
  Health health;
  float gamma;
  float truth;
};

// The other finger: a steady contact of another place, force and load.
class OtherFinger final : public GraspFrames {
 public:
  OtherFinger(const ChainSetup& chain, const FaultSetup& setup, std::size_t grasp)
      : drawn_(draw_grasp(chain.scene, setup.seed, kOtherGrasp + grasp)),
        frames_(chain.layout, setup.sensing.kind, setup.sensing.noise),
        random_(RandomStream(setup.seed).stream(kOtherGrasp + grasp)) {
    contact::LoadHistory contact(contact::make_body_pair(
        contact::body_of(chain.scene.skin),
        {drawn_.contact.radius_m, drawn_.contact.modulus_pa, drawn_.contact.poisson}));
    const LoadSegment& loaded = drawn_.segments.at(1);
    contact.move_to(loaded.normal_n, 0, loaded.friction);
    contact.move_to(loaded.normal_n, loaded.shear_n, loaded.friction);
    frames_.sense(contact, drawn_.contact.x_m, drawn_.contact.y_m);
    moment_.truth = {contact.safety_margin(), contact.friction()};
  }
  bool next() override {
    ++moment_.number;
    return true;
  }
  FrameSlot& sense() override {
    frames_.sense(drawn_.direction_rad, random_.stream(moment_.number));
    slot_ = slot_of(frames_, 1);
    return slot_;
  }

 private:
  Grasp drawn_;
  TrialFrames frames_;
  RandomStream random_;
  FrameSlot slot_;
};

// One fault's estimator, beside that of the healthy sensor.
struct Runner {
  Runner(const Estimator& of, Fault f, std::uint64_t first, const RandomStream& random)
      : fault(f),
        estimator(of.chain()),
        injector(f, of.setup.layout, first, random),
        normal_pa(of.setup.layout.size()),
        shear_x_pa(of.setup.layout.size()),
        shear_y_pa(of.setup.layout.size()) {}

  // Frame by frame: spoils a copy of what the healthy sensor gives.
  void receive(const FrameSlot& sound, const Frame& other) {
    FrameSlot spoilt;
    spoilt.normal_pa = normal_pa;
    spoilt.shear_x_pa = shear_x_pa;
    spoilt.shear_y_pa = shear_y_pa;
    copy_frame(sound, spoilt);
    injector.spoil(spoilt, other);
    estimate = estimator.estimate(spoilt.view());
  }

  Fault fault;
  EstimatorChain estimator;
  FaultInjector injector;
  std::vector<float> normal_pa, shear_x_pa, shear_y_pa;  // of the spoilt frame
  Estimate estimate;
  std::vector<Answer> said;
};

Answer said_of(const Estimate& estimate, double truth) {
  return {estimate.state, estimate.health, static_cast<float>(estimate.gamma.value_or(kUnknown)),
          static_cast<float>(truth)};
}

bool ok(const Answer& at) {
  return at.state == State::ok;
}

bool too_safe(const Answer& at) {
  return ok(at) && static_cast<double>(at.gamma - at.truth) > kGrossError;
}

using HealthCounts = std::array<std::uint64_t, kHealths>;

struct Found {
  FaultLine sums;
  HealthCounts false_alarms{};
  long after = -1;
};

Found compare(const std::vector<Answer>& sound, const std::vector<Answer>& spoilt, std::uint64_t first) {
  Found found;
  bool named = false, changed = false;
  for (std::size_t i = 0; i < spoilt.size(); ++i) {
    if (is_implausible(sound[i].health)) ++found.false_alarms[static_cast<std::size_t>(sound[i].health)];
    if (i + 1 < first) continue;
    const auto since = static_cast<long>(i + 1 - first);
    const bool bad = is_implausible(spoilt[i].health);
    if (found.after < 0 && (bad || (ok(sound[i]) && !ok(spoilt[i])))) found.after = since;
    if (bad && !named) found.sums.as = spoilt[i].health;
    named = named || bad;
    changed = changed || (ok(spoilt[i]) && ok(sound[i]) &&
                          std::fabs(static_cast<double>(spoilt[i].gamma - sound[i].gamma)) > kNoEffect);
    if (since <= static_cast<long>(kGraceFrames)) continue;
    found.sums.answered += ok(spoilt[i]) ? 1 : 0;
    found.sums.too_safe += too_safe(spoilt[i]) && !too_safe(sound[i]) ? 1 : 0;
    found.sums.sound_answered += ok(sound[i]) ? 1 : 0;
    found.sums.sound_too_safe += too_safe(sound[i]) ? 1 : 0;
  }
  found.sums.sound_frames = sound.size();
  found.sums.reported = found.after >= 0 ? 1 : 0;
  found.sums.named = named ? 1 : 0;
  found.sums.without_effect = found.after < 0 && !changed ? 1 : 0;
  return found;
}

// When the faults of a grasp of `frames` frames begin: the number of the first, from 1.
std::uint64_t first_frame(std::uint64_t seed, std::size_t number, std::uint64_t frames) {
  const double begins = RandomStream(seed).stream(kFaultStream).uniform(number, kEarliest, kLatest);
  return static_cast<std::uint64_t>(begins * static_cast<double>(frames)) + 1;
}

// The estimators of all faults on the frames of one grasp.
class Faulty {
 public:
  Faulty(const Estimator& estimator, const std::vector<Fault>& faults, std::uint64_t first,
         const RandomStream& random)
      : first_(first) {
    for (const Fault fault : faults)
      runners_.push_back(std::make_unique<Runner>(estimator, fault, first, random.stream(kFaultStream)));
  }

  // `other`: the other finger, at the same moment.
  void receive(const FrameSlot& sound, GraspFrames& other) {
    for (const auto& runner : runners_)
      runner->receive(sound, exchanged(*runner, sound.sequence) ? other.sense().view() : Frame{});
  }

  // After a frame: what the healthy sensor's estimator made of it, and the true margins of both fingers.
  void note(const Estimate& sound, double truth, double other_truth) {
    sound_.push_back(said_of(sound, truth));
    for (const auto& runner : runners_)
      runner->said.push_back(
          said_of(runner->estimate, exchanged(*runner, sound_.size()) ? other_truth : truth));
  }

  std::vector<Found> found() const {
    std::vector<Found> all;
    for (const auto& runner : runners_) all.push_back(compare(sound_, runner->said, first_));
    return all;
  }

 private:
  bool exchanged(const Runner& runner, std::uint64_t sequence) const {
    return runner.fault == Fault::other_finger && sequence >= first_;
  }

  std::uint64_t first_;
  std::vector<std::unique_ptr<Runner>> runners_;
  std::vector<Answer> sound_;
};

// One grasp, simulated once for all faults. Returns what was found of each. `other` stays at its last frame
// when it ends.
std::vector<Found> play(GraspFrames& frames, GraspFrames& other, const Estimator& estimator, Faulty faulty) {
  EstimatorChain chain = estimator.chain();
  for (std::uint64_t sequence = 1; frames.next(); ++sequence) {
    other.next();
    FrameSlot sound = frames.sense();
    sound.sequence = sequence;
    faulty.receive(sound, other);
    faulty.note(chain.estimate(sound.view()), frames.moment().truth.gamma, other.moment().truth.gamma);
  }
  return faulty.found();
}

// Random grasps up to the move that no sensor can see.
std::vector<Found> play_random(const Estimator& estimator, const FaultSetup& setup, std::size_t number,
                               const std::vector<Fault>& faults) {
  const ChainSetup& chain = estimator.setup;
  Grasp grasp = draw_grasp(chain.scene, setup.seed, number);
  std::erase_if(grasp.segments, [](const LoadSegment& segment) { return segment.move == Move::unseen; });
  const RandomStream draws = RandomStream(setup.seed).stream(number);
  RandomFrames frames(std::move(grasp), chain.layout, chain.scene.skin, setup.sensing, draws);
  OtherFinger other(chain, setup, number);
  return play(frames, other, estimator,
              Faulty(estimator, faults, first_frame(setup.seed, number, frames.length()), draws));
}

// Grasps of a preset. The other finger holds.
std::vector<Found> play_preset(const PresetBench& bench, const Estimator& estimator, const FaultSetup& setup,
                               std::size_t number, const std::vector<Fault>& faults) {
  const GraspKind kind = number % 2 == 0 ? GraspKind::hold : GraspKind::slip;
  SimulatedFrames frames(bench, draw_preset_grasp(bench, kind, setup.seed, number));
  SimulatedFrames other(bench, draw_preset_grasp(bench, GraspKind::hold, setup.seed, kOtherGrasp + number));
  return play(frames, other, estimator,
              Faulty(estimator, faults, first_frame(setup.seed, number, frames.length()),
                     RandomStream(setup.seed).stream(number)));
}

Health most_often(const HealthCounts& counts) {
  return static_cast<Health>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

// Of one fault, the one of this place in each grasp's findings.
FaultLine together(Fault fault, const std::vector<std::vector<Found>>& grasps, std::size_t place) {
  FaultLine line;
  line.fault = fault;
  line.grasps = grasps.size();
  std::vector<long> after;
  HealthCounts as{}, false_as{};
  for (const auto& findings : grasps) {
    const Found& grasp = findings[place];
    line.reported += grasp.sums.reported;
    line.named += grasp.sums.named;
    as[static_cast<std::size_t>(grasp.sums.as)] += grasp.sums.named;
    line.without_effect += grasp.sums.without_effect;
    line.answered += grasp.sums.answered;
    line.too_safe += grasp.sums.too_safe;
    line.sound_answered += grasp.sums.sound_answered;
    line.sound_too_safe += grasp.sums.sound_too_safe;
    const std::uint64_t alarms_before = line.false_alarms;
    for (std::size_t i = 0; i < kHealths; ++i) {
      false_as[i] += grasp.false_alarms[i];
      line.false_alarms += grasp.false_alarms[i];
    }
    line.grasps_with_false_alarms += line.false_alarms > alarms_before ? 1 : 0;
    line.sound_frames += grasp.sums.sound_frames;
    if (grasp.after >= 0) after.push_back(grasp.after);
  }
  line.as = most_often(as);
  line.false_as = most_often(false_as);
  std::sort(after.begin(), after.end());
  if (!after.empty()) {
    line.median_frames = after[after.size() / 2];
    line.last_frames = after.back();
  }
  return line;
}

template <class Play>
std::vector<FaultLine> lines_of(const std::vector<Fault>& faults, const FaultSetup& setup, const Done& done,
                                Play play_grasp) {
  const std::vector<std::vector<Found>> found = collect(setup.grasps, setup.threads, done, play_grasp);
  std::vector<FaultLine> lines;
  for (std::size_t f = 0; f < faults.size(); ++f) lines.push_back(together(faults[f], found, f));
  return lines;
}

}  // namespace

std::vector<FaultLine> measure_faults(const Estimator& estimator, const std::vector<Fault>& faults,
                                      const FaultSetup& setup, const Done& done) {
  return lines_of(faults, setup, done,
                  [&](std::size_t i) { return play_random(estimator, setup, i, faults); });
}

std::vector<FaultLine> measure_faults(const PresetBench& bench, const ChainSetup& chain,
                                      const std::vector<Fault>& faults, const FaultSetup& setup,
                                      const Done& done) {
  const Estimator estimator{chain, nullptr};
  return lines_of(faults, setup, done,
                  [&](std::size_t i) { return play_preset(bench, estimator, setup, i, faults); });
}

}  // namespace lab
