#include "lab/torque/measure.hpp"

#include <utility>

#include "lab/collect.hpp"
#include "lab/estimator.hpp"
#include "lab/grasp/drive.hpp"

namespace lab {
namespace {

using namespace slipd;

// Sides of layouts that are given the friction.
constexpr std::size_t kFewSide = 6;

struct TurningRow {
  Course course;
  Mix mix;
};

std::vector<TurningRow> rows_of(std::size_t side) {
  std::vector<TurningRow> rows;
  for (const Course course : {Course::frame, Course::ramp, Course::history}) {
    if (course == Course::frame && side <= kFewSide) continue;
    for (const Mix mix : {Mix::pull, Mix::both, Mix::turn}) {
      if (course == Course::history && mix != Mix::both) continue;
      rows.push_back({course, mix});
    }
  }
  return rows;
}

// A method on a layout, ready to be made anew for each grasp.
struct TurningEstimator {
  std::string method, used;
  Estimator estimator;
};

// What `auto` chooses is found once.
TurningEstimator estimator_of(const std::string& method, std::size_t side, const TorqueSetup& setup) {
  Estimator made = make_estimator(paper_chain(side, method_choices().at(method), setup.noise), setup.threads);
  const Method used = made.method();
  MethodChoice& choice = made.setup.estimator.method;
  if (choice == MethodChoice::automatic)
    choice = used == Method::moments ? MethodChoice::moments : MethodChoice::fit;
  return {method, std::string(to_string(used)), std::move(made)};
}

struct FoundByEstimator {
  TorqueTally tally;
  std::vector<TurningPoint> points;
};

// One contact of a row through all estimators. Nothing pulls in the first move, while the grip closes.
std::vector<FoundByEstimator> play(const std::vector<TurningEstimator>& estimators, std::size_t side,
                                   TurningRow row, const TorqueSetup& setup, std::size_t index) {
  const ChainSetup& common = estimators.front().estimator.setup;
  const std::uint64_t seed = setup.seed + 1;  // not the seed of training
  const ContactDraw contact = draw_contact(common.scene, seed, index);
  const RandomStream random = RandomStream(seed).stream(index).stream(static_cast<std::uint64_t>(row.mix));
  std::vector<EstimatorChain> chains;
  for (const TurningEstimator& each : estimators) {
    ChainSetup chain = each.estimator.setup;
    chain.estimator.tracking = row.course != Course::frame;
    if (side <= kFewSide) chain.friction = contact.friction;
    chains.emplace_back(chain, each.estimator.model);
  }
  std::vector<FoundByEstimator> found(chains.size());
  TorqueFrames frames(contact, common.scene.skin, common.layout, setup.noise, random.stream(0),
                      draw_moves(contact, row.course, row.mix, random.stream(1)));
  drive(frames, chains, [&](const GraspSample& sample) {
    if (sample.at.move == 0) return;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Estimate& estimate = sample.estimates[i];
      found[i].tally.add(estimate, sample.at.truth, sample.taken_us[i]);
      if (row.course == Course::frame && estimate.gamma)
        found[i].points.push_back({sample.at.truth.gamma, *estimate.gamma});
    }
  });
  return found;
}

}  // namespace

void TorqueTally::add(const Estimate& estimate, const Truth& truth, double estimate_us) {
  margins.add(estimate, truth);
  if (truth.gamma < kNear) near.add(estimate, truth);
  taken_us.add(estimate_us);
}

void TorqueTally::add(const TorqueTally& other) {
  margins.add(other.margins);
  near.add(other.near);
  taken_us.add(other.taken_us);
}

std::vector<TorqueLine> measure_torque(const TorqueSetup& setup,
                                       const std::function<void(double, const char*)>& done) {
  std::vector<TorqueLine> lines;
  for (const std::size_t side : setup.sides) {
    const std::string title = std::to_string(side) + " x " + std::to_string(side);
    std::vector<TurningEstimator> estimators;
    for (const std::string& method : setup.methods) {
      if (side <= kFewSide && method != "auto") continue;  // always fit
      estimators.push_back(estimator_of(method, side, setup));
    }
    if (estimators.empty()) continue;
    for (const TurningRow row : rows_of(side)) {
      const std::size_t count = row.course == Course::frame ? setup.frames : setup.grasps;
      const auto found = collect(
          count, setup.threads,
          [&](double share) { done(share, (title + ' ' + name_of(row.course)).c_str()); },
          [&](std::size_t i) { return play(estimators, side, row, setup, i); });
      for (std::size_t i = 0; i < estimators.size(); ++i) {
        TorqueLine line{.side = side,
                        .method = estimators[i].method,
                        .used = estimators[i].used,
                        .course = row.course,
                        .mix = row.mix,
                        .friction_given = side <= kFewSide,
                        .tally = {},
                        .points = {}};
        for (const auto& each : found) {
          line.tally.add(each[i].tally);
          line.points.insert(line.points.end(), each[i].points.begin(), each[i].points.end());
        }
        lines.push_back(std::move(line));
      }
    }
  }
  return lines;
}

}  // namespace lab
