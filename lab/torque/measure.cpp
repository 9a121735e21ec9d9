#include "lab/torque/measure.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "core/chain/chain.hpp"
#include "lab/histories/drive.hpp"
#include "lab/torque/grasp.hpp"
#include "paper/model_setup.hpp"
#include "paper/train.hpp"
#include "paper/validation/thread_clock.hpp"
#include "tools/offline/parallel.hpp"

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
  ChainSetup setup;
  std::shared_ptr<const Model> model;
};

MethodChoice choice_of(const std::string& method) {
  static const std::map<std::string, MethodChoice> kChoices{{"auto", MethodChoice::automatic},
                                                            {"registered", MethodChoice::registered},
                                                            {"moments", MethodChoice::moments},
                                                            {"fit", MethodChoice::fit}};
  return kChoices.at(method);
}

// What `auto` chooses is found once.
TurningEstimator make_estimator(const std::string& method, std::size_t side, const TorqueSetup& setup) {
  TurningEstimator made{
      .method = method, .used = {}, .setup = paper_chain(side, choice_of(method), setup.noise), .model = {}};
  if (needs_model(made.setup))
    made.model = std::make_shared<const Model>(train(model_setup_of(made.setup), setup.threads));
  const Method used = EstimatorChain(made.setup, made.model).method();
  made.used = std::string(to_string(used));
  if (made.setup.estimator.method == MethodChoice::automatic)
    made.setup.estimator.method = used == Method::moments ? MethodChoice::moments : MethodChoice::fit;
  return made;
}

struct Found {
  TurningTally tally;
  std::vector<TurningPoint> points;
};

// One contact of a row through all estimators.
std::vector<Found> play(const std::vector<TurningEstimator>& estimators, std::size_t side, TurningRow row,
                        const TorqueSetup& setup, std::size_t index) {
  const ChainSetup& common = estimators.front().setup;
  const std::uint64_t seed = setup.seed + 1;  // not the seed of training
  const ContactDraw contact = draw_contact(common.scene, seed, index);
  const RandomStream random = RandomStream(seed).stream(index).stream(static_cast<std::uint64_t>(row.mix));
  std::vector<EstimatorChain> chains;
  for (const TurningEstimator& each : estimators) {
    ChainSetup chain = each.setup;
    chain.estimator.tracking = row.course != Course::frame;
    if (side <= kFewSide) chain.friction = contact.friction;
    chains.emplace_back(chain, each.model);
  }
  std::vector<Found> found(chains.size());
  TurningGrasp grasp(contact, common.scene.skin, common.layout, setup.noise, random.stream(0));
  const auto moves = draw_moves(contact, row.course, row.mix, random.stream(1));
  for (const TurningMove& move : moves) {
    const bool counts = &move != &moves.front();  // nothing pulls while the grip closes
    grasp.play(move, [&](const Frame& frame, Truth truth) {
      for (std::size_t i = 0; i < chains.size(); ++i) {
        const double start_us = thread_us();
        const Estimate estimate = chains[i].estimate(frame);
        if (!counts) continue;
        found[i].tally.add(estimate, truth, thread_us() - start_us);
        if (row.course == Course::frame && estimate.gamma)
          found[i].points.push_back({truth.gamma, *estimate.gamma});
      }
    });
  }
  return found;
}

}  // namespace

const char* name_of(Mix mix) noexcept {
  static constexpr const char* kNames[] = {"pull", "both", "turn"};
  return kNames[static_cast<std::size_t>(mix)];
}

const char* name_of(Course course) noexcept {
  static constexpr const char* kNames[] = {"frame", "ramp", "history"};
  return kNames[static_cast<std::size_t>(course)];
}

void TurningTally::add(const Estimate& estimate, Truth truth, double taken_us) {
  margins_.add(estimate, truth.gamma);
  taken_us_.push_back(static_cast<float>(taken_us));
  const bool near = truth.gamma < kNear;
  near_ += near ? 1 : 0;
  if (!estimate.gamma) return;
  near_answered_ += near ? 1 : 0;
  const double above = *estimate.gamma - truth.gamma;
  off_ += above;
  above_ += above > kTurningTooSafe ? 1 : 0;
  most_above_ = std::max(most_above_, above);
  if (!near || !estimate.friction) return;
  const double off = std::fabs(*estimate.friction / truth.friction - 1);
  frictions_ += 1;
  friction_errors_ += off;
  frictions_wrong_ += off > 0.1 ? 1 : 0;
}

void TurningTally::add(const TurningTally& other) {
  margins_.add(other.margins_);
  off_ += other.off_;
  above_ += other.above_;
  most_above_ = std::max(most_above_, other.most_above_);
  near_ += other.near_;
  near_answered_ += other.near_answered_;
  frictions_ += other.frictions_;
  friction_errors_ += other.friction_errors_;
  frictions_wrong_ += other.frictions_wrong_;
  taken_us_.insert(taken_us_.end(), other.taken_us_.begin(), other.taken_us_.end());
}

double TurningTally::too_safe() const noexcept {
  return above_ / (margins_.answered() * margins_.frames());
}
double TurningTally::bias() const noexcept {
  return off_ / (margins_.answered() * margins_.frames());
}
double TurningTally::friction_error() const noexcept {
  return frictions_ > 0 ? friction_errors_ / frictions_ : kUnknown;
}
double TurningTally::friction_wrong() const noexcept {
  return frictions_ > 0 ? frictions_wrong_ / frictions_ : kUnknown;
}
double TurningTally::answered_near() const noexcept {
  return near_ > 0 ? near_answered_ / near_ : kUnknown;
}
double TurningTally::median_us() const {
  if (taken_us_.empty()) return kUnknown;
  std::vector<float> times = taken_us_;
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return static_cast<double>(*middle);
}

std::vector<TorqueLine> measure_torque(const TorqueSetup& setup,
                                       const std::function<void(double, const char*)>& done) {
  std::vector<TorqueLine> lines;
  for (const std::size_t side : setup.sides) {
    const std::string title = std::to_string(side) + " x " + std::to_string(side);
    std::vector<TurningEstimator> estimators;
    for (const std::string& method : setup.methods) {
      if (side <= kFewSide && method != "auto") continue;  // always fit
      estimators.push_back(make_estimator(method, side, setup));
    }
    if (estimators.empty()) continue;
    for (const TurningRow row : rows_of(side)) {
      const std::size_t count = row.course == Course::frame ? setup.frames : setup.grasps;
      std::vector<std::vector<Found>> found(count);
      offline::for_each_index(
          count, setup.threads, [&](std::size_t i) { found[i] = play(estimators, side, row, setup, i); },
          [&](double share) { done(share, (title + ' ' + name_of(row.course)).c_str()); });
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
