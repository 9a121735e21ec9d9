#include "lab/stability/trials.hpp"

#include <numbers>
#include <span>
#include <utility>

#include "tools/offline/parallel.hpp"

namespace lab {
namespace {

using namespace slipd;

std::vector<EstimatorChain> chains_of(const TrialSetup& setup) {
  std::vector<EstimatorChain> chains;
  for (const auto& method : kUntrained) {
    ChainSetup chain{
        .layout = layout_of(setup), .scene = scene_of(setup), .estimator = {}, .alerts = {}, .friction = {}};
    chain.estimator.method = method.choice;
    chain.estimator.tracking = false;
    chains.emplace_back(chain, nullptr);
  }
  return chains;
}

// One sensor and its estimator chains. Each contact is gripped without shear and then estimated once.
class ChainTrials {
 public:
  explicit ChainTrials(const TrialSetup& setup)
      : chains_(chains_of(setup)), statistics_(chains_.size()), nothing_(layout_of(setup).size(), 0.0F) {}

  // grown: the share of the tangential force that rose together with the normal force, and not after it.
  void run(const Frame& frame, double truth, double grown = 0) {
    const auto share = static_cast<float>(1 - grown);
    const auto part = [share](std::span<const float> all, std::vector<float>& out) {
      out.assign(all.begin(), all.end());
      for (float& value : out) value *= share;
    };
    part(frame.normal_pa, normal_);
    part(frame.shear_x_pa, x_);
    part(frame.shear_y_pa, y_);
    const bool alone = grown == 0;
    const Frame before{1, 1, normal_, alone ? nothing_ : x_, alone ? nothing_ : y_};
    for (std::size_t m = 0; m < chains_.size(); ++m) {
      chains_[m].estimate(before);
      statistics_[m].add(chains_[m].estimate(frame), {.gamma = truth});
      chains_[m].estimate({1, 1, nothing_, nothing_, nothing_});
    }
  }

  std::vector<Tally> statistics() { return std::move(statistics_); }

 private:
  std::vector<EstimatorChain> chains_;
  std::vector<Tally> statistics_;
  std::vector<float> nothing_, normal_, x_, y_;
};

}  // namespace

TaxelLayout layout_of(const TrialSetup& setup) {
  return TaxelLayout::grid(setup.side, setup.side, 0.016 / static_cast<double>(setup.side));
}

Scene scene_of(const TrialSetup& setup) {
  Scene scene;
  scene.objects = paper_objects();
  scene.offset_m = 0.002;
  scene.noise = setup.noise;
  return scene;
}

std::vector<RobustnessRow> measure_extremes(const TrialSetup& setup, const Done& done) {
  std::vector<RobustnessRow> rows;
  std::vector<Axis> axes;
  for (const Axis axis : kAxes) {
    for (const double place : places_on(axis)) {
      rows.push_back({std::string(name_of(axis)), place, {}});
      axes.push_back(axis);
    }
  }
  const TaxelLayout layout = layout_of(setup);
  const auto work = [&](std::size_t i) {
    ChainTrials trials(setup);
    TrialFrames frames(layout, setup.kind, setup.noise);
    const RandomStream random = RandomStream(setup.seed).stream(static_cast<std::uint64_t>(axes[i]));
    for (std::size_t j = 0; j < setup.contacts; ++j) {
      const RandomStream u = random.stream(j);
      const Case in = draw_case(axes[i], rows[i].strength, u);
      contact::LoadHistory contact(contact::make_body_pair({in.radius_1, in.modulus_1, in.poisson_1},
                                                           {in.radius_2, in.modulus_2, in.poisson_2}));
      contact.move_to(in.normal_n, 0, in.friction);
      contact.move_to(in.normal_n, in.load * in.friction * in.normal_n, in.friction);
      const RandomStream place = u.stream(1);
      frames.sense(contact, place.uniform(0, -0.002, 0.002), place.uniform(1, -0.002, 0.002));
      trials.run(frames.sense(2 * std::numbers::pi * place.uniform(2), u.stream(2)), 1 - in.load);
    }
    rows[i].by_method = trials.statistics();
  };
  offline::for_each_index(rows.size(), setup.threads, work, done);
  return rows;
}

std::vector<RobustnessRow> measure_perturbations(const TrialSetup& setup, const Done& done) {
  std::vector<RobustnessRow> rows;
  std::vector<Perturbation> perturbations;
  for (std::size_t f = 0; f < kPerturbations; ++f) {
    for (const double strength : strengths(static_cast<Perturbation>(f))) {
      perturbations.push_back(static_cast<Perturbation>(f));
      rows.push_back({std::string(name_of(perturbations.back())), strength, {}});
    }
  }
  const Scene scene = scene_of(setup);
  const auto work = [&](std::size_t i) {
    ChainTrials trials(setup);
    Adversary adversary(layout_of(setup), setup.kind, setup.noise);
    for (std::size_t j = 0; j < setup.contacts; ++j) {
      const Trial trial = adversary.make(perturbations[i], rows[i].strength, scene, setup.seed, j);
      trials.run(trial.frame, trial.truth, perturbations[i] == Perturbation::grown ? rows[i].strength : 0);
    }
    rows[i].by_method = trials.statistics();
  };
  offline::for_each_index(rows.size(), setup.threads, work, done);
  return rows;
}

}  // namespace lab
