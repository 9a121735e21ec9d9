#include "tools/sliplab/replay/run.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "config/settings.hpp"
#include "core/chain/chain.hpp"
#include "core/grasp/grasp.hpp"
#include "paper/model/model.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/replay/frames.hpp"

namespace sliplab {
namespace {

using namespace slipd;

// The values of the row before.
class LastValues {
 public:
  // Whether this frame has them all.
  bool repeats(const Frame& frame) {
    std::vector<float> now;
    for (const auto& channel : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa})
      now.insert(now.end(), channel.begin(), channel.end());
    const bool same = now == values_;
    values_ = std::move(now);
    return same;
  }

 private:
  std::vector<float> values_;
};

ReplayRun play(const Settings& settings, const FileOfSensor& job, std::optional<double> releasing_from_s) {
  FileFrames frames(settings, job);
  if (needs_model(frames.setup()))
    throw offline::WrongUse("sensor " + job.sensor +
                            " needs a trained model: choose another estimator.method");
  EstimatorChain chain(frames.setup(), nullptr);
  ReplayRun run{.sensor = job.sensor, .file = job.file, .rows = {}, .fault = {}};
  LastValues last;
  std::int64_t time_ns = 0;
  for (std::uint64_t row = 0;; ++row) {
    const FileFrames::Outcome outcome = frames.next();
    if (outcome == FileFrames::Outcome::end) break;
    ReplayRow& out = run.rows.emplace_back();
    out.row = row;
    if (outcome == FileFrames::Outcome::corrupt) {  // the daemon counts it and estimates nothing
      out.time_s = static_cast<double>(time_ns) * 1e-9;
      out.estimate.state = State::fault;
      if (row > 0) out.estimate.alert = without_frames(run.rows[row - 1].estimate.alert);
      continue;
    }
    time_ns = frames.time_ns();
    if (releasing_from_s) chain.set_releasing(static_cast<double>(time_ns) * 1e-9 >= *releasing_from_s);
    out.estimate = chain.estimate(frames.frame());
    run.repeated += last.repeats(frames.frame()) ? 1 : 0;
    out.time_s = static_cast<double>(time_ns) * 1e-9;
  }
  run.unrisen = frames.unrisen();
  run.wanted_rate_hz = frames.rate_hz();
  run.fault = frames.fault();
  return run;
}

// The only run of the sensor; null: there is none, or several.
const ReplayRun* run_of(const std::vector<ReplayRun>& runs, const std::string& sensor) {
  const ReplayRun* found = nullptr;
  for (const ReplayRun& run : runs) {
    if (run.sensor != sensor) continue;
    if (found != nullptr) return nullptr;
    found = &run;
  }
  return found;
}

ReplayRun judge_grasp(const GraspSettings& grasp, const std::vector<const ReplayRun*>& members,
                      const AlertSettings& alerts) {
  ReplayRun made{.sensor = grasp.name, .file = {}, .rows = {}, .fault = {}};
  GraspTracker tracker(alerts, grasp.poses);
  std::vector<Estimate> latest(members.size());
  std::vector<std::size_t> next(members.size(), 0);
  while (true) {
    double time_s = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (next[i] < members[i]->rows.size()) time_s = std::min(time_s, members[i]->rows[next[i]].time_s);
    }
    if (std::isinf(time_s)) return made;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::vector<ReplayRow>& rows = members[i]->rows;
      for (; next[i] < rows.size() && rows[next[i]].time_s <= time_s; ++next[i]) {
        latest[i] = rows[next[i]].estimate;
        latest[i].published_ns = std::llround(time_s * 1e9);
      }
    }
    made.rows.push_back({.time_s = time_s, .row = made.rows.size(), .estimate = tracker.judge(latest)});
  }
}

void add_grasps(const Settings& settings, std::vector<ReplayRun>& runs) {
  std::vector<ReplayRun> grasps;
  for (const GraspSettings& grasp : settings.grasps) {
    std::vector<const ReplayRun*> members;
    for (const std::string& sensor : grasp.sensors) members.push_back(run_of(runs, sensor));
    if (std::find(members.begin(), members.end(), nullptr) == members.end())
      grasps.push_back(judge_grasp(grasp, members, settings.alerts));
  }
  std::move(grasps.begin(), grasps.end(), std::back_inserter(runs));
}

}  // namespace

std::vector<ReplayRun> replay(const std::filesystem::path& scene, const std::string& sensor,
                              const std::vector<std::string>& files, const offline::Shard& shard,
                              std::optional<double> releasing_from_s) {
  const Settings settings = load_scene(scene);
  std::vector<ReplayRun> runs;
  std::size_t unit = 0;
  for (const FileOfSensor& job : files_of(settings, sensor, files)) {
    if (shard.has(unit)) {
      runs.push_back(play(settings, job, releasing_from_s));
      runs.back().unit = unit;
    }
    ++unit;
  }
  if (shard.whole()) add_grasps(settings, runs);
  return runs;
}

}  // namespace sliplab
