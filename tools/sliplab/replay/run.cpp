#include "tools/sliplab/replay/run.hpp"

#include <utility>

#include "config/settings.hpp"
#include "core/chain/chain.hpp"
#include "paper/model/model.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/replay/frames.hpp"

namespace sliplab {
namespace {

using namespace slipd;

ReplayRun play(const Settings& settings, const FileOfSensor& job) {
  FileFrames frames(settings, job);
  if (needs_model(frames.setup()))
    throw offline::WrongUse("sensor " + job.sensor +
                            " needs a trained model: choose another estimator.method");
  EstimatorChain chain(frames.setup(), nullptr);
  ReplayRun run{.sensor = job.sensor, .file = job.file, .rows = {}, .fault = {}};
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
    out.estimate = chain.estimate(frames.frame());
    out.time_s = static_cast<double>(time_ns) * 1e-9;
  }
  run.fault = frames.fault();
  return run;
}

}  // namespace

std::vector<ReplayRun> replay(const std::filesystem::path& scene, const std::string& sensor,
                              const std::vector<std::string>& files, const offline::Shard& shard) {
  const Settings settings = load_scene(scene);
  std::vector<ReplayRun> runs;
  std::size_t unit = 0;
  for (const FileOfSensor& job : files_of(settings, sensor, files)) {
    if (shard.has(unit)) {
      runs.push_back(play(settings, job));
      runs.back().unit = unit;
    }
    ++unit;
  }
  return runs;
}

}  // namespace sliplab
