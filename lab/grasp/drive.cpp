#include "lab/grasp/drive.hpp"

#include <optional>
#include <vector>

#include "lab/grasp/friction_trace.hpp"
#include "paper/validation/thread_clock.hpp"

namespace lab {

using namespace slipd;

void drive(GraspFrames& frames, std::span<EstimatorChain> chains,
           const std::function<void(const GraspSample&)>& watch, const DriveOptions& options) {
  std::vector<Estimate> estimates(chains.size());
  std::vector<double> taken_us(chains.size());
  std::optional<FrictionTrace> trace;
  if (const auto known = frames.traced(); options.trace && known.contact != nullptr)
    trace.emplace(*known.layout, known.x_m, known.y_m);
  while (frames.next()) {
    const GraspMoment& at = frames.moment();
    const bool received = !options.comes || options.comes(at.number);
    bool traced = true;
    if (received) {
      const Frame frame = frames.sense().view();
      for (std::size_t i = 0; i < chains.size(); ++i) {
        const double start_us = thread_us();
        estimates[i] = chains[i].estimate(frame);
        taken_us[i] = thread_us() - start_us;
      }
      if (trace) {
        const auto now = frames.traced();
        traced = trace->update(*now.contact, now.shear_sigma_pa);
      }
    }
    watch({at, estimates, taken_us, received, traced});
  }
}

void drive(GraspFrames& frames, EstimatorChain& chain, const std::function<void(const GraspSample&)>& watch,
           const DriveOptions& options) {
  drive(frames, std::span(&chain, 1), watch, options);
}

}  // namespace lab
