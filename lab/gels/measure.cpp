#include "lab/gels/measure.hpp"

#include "lab/grasp/drive.hpp"

namespace lab {

using namespace slipd;

namespace {

// The nodes, and the scale, of slipd-camera's profile own-dots.
constexpr double kPitch_m = 0.0018, kMPerPx = 0.058e-3;
constexpr double kJustBefore_s = 1;

GelLine measure_grasp(const GelGrasp& grasp, GelFrames& frames, EstimatorChain& chain, double rate_hz) {
  const double from_s = grasp.slides_s - kJustBefore_s;
  GelLine line;
  line.course = grasp.course;
  line.grasps = 1;
  bool raised = false, told = false;
  drive(frames, chain, [&](const GraspSample& sample) {
    const double now_s = sample.at.time_s;
    const bool slip = sample.estimate().alert == Alert::slip;
    const bool rises = slip && !raised;
    raised = slip;
    if (now_s < from_s) {
      if (sample.at.normal_n > 0) line.held_s += 1 / rate_hz;
      if (rises) ++line.false_alerts;
    } else if (slip && !told) {
      told = true;
      const double after_s = now_s - grasp.slides_s, soon_s = GelLine::kSoonPictures / rate_hz;
      line.before = after_s < 0 ? 1 : 0;
      line.soon = after_s <= soon_s ? 1 : 0;
      line.soon_after_loss = after_s <= soon_s || (grasp.is_lost() && now_s <= grasp.lost_s + soon_s) ? 1 : 0;
      line.told = 1;
      line.after_s.add(after_s);
    }
  });
  line.alarmed = line.false_alerts > 0 ? 1 : 0;
  return line;
}

}  // namespace

void GelLine::add(const GelLine& other) {
  grasps += other.grasps;
  alarmed += other.alarmed;
  held_s += other.held_s;
  false_alerts += other.false_alerts;
  before += other.before;
  soon += other.soon;
  soon_after_loss += other.soon_after_loss;
  told += other.told;
  after_s.add(other.after_s);
}

std::vector<GelLine> measure_gels(const GelSetup& setup, const Done& done) {
  const GelSurface surface(GelFrames::kThickness_m, GelFrames::kPoisson);
  const ChainSetup chain{.layout = TaxelLayout::grid(9, 7, kPitch_m),
                         .sensor_class = SensorClass::displacement,
                         .scene = {},
                         .estimator = {},
                         .alerts = {},
                         .friction = {}};
  const auto measured = collect(kGelCourses * setup.grasps, setup.threads, done, [&](std::size_t i) {
    const RandomStream random = RandomStream(setup.seed).stream(i);
    const auto grasp = draw_gel_grasp(static_cast<GelCourse>(i / setup.grasps), random.stream(0));
    GelFrames frames(grasp, surface, chain.layout, setup.rate_hz, setup.noise_px * kMPerPx, random.stream(1));
    EstimatorChain estimator(chain, nullptr);
    return measure_grasp(grasp, frames, estimator, setup.rate_hz);
  });
  std::vector<GelLine> lines(kGelCourses);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    GelLine& line = lines[i / setup.grasps];
    line.course = measured[i].course;
    line.add(measured[i]);
  }
  return lines;
}

}  // namespace lab
