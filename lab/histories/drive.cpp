#include "lab/histories/drive.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/contact/history.hpp"
#include "core/contact/imprint.hpp"
#include "lab/histories/friction_trace.hpp"
#include "paper/validation/thread_clock.hpp"

namespace lab {
namespace {

// Standard deviation of one taxel's shear; uniform noise of half-width w has w/sqrt 3.
double shear_sigma_pa(slipd::TrialFrames& frames, const Sampling& sensing) {
  constexpr double kLeastNoise = 1e-6;  // of the largest value: a sensor without noise rounds
  const auto values = sensing.kind == slipd::NoiseKind::sensor ? frames.normal_pa() : frames.shear_pa();
  float most_pa = 0;
  for (const float value : values) most_pa = std::max(most_pa, std::fabs(value));
  return std::max(sensing.noise, kLeastNoise) * static_cast<double>(most_pa) / std::sqrt(3.0);
}

}  // namespace

slipd::ChainSetup paper_chain(std::size_t side, slipd::MethodChoice method, double noise) {
  const double pitch_m = side == 4 ? 0.0047 : 0.016 / static_cast<double>(side);
  slipd::ChainSetup chain{.layout = slipd::TaxelLayout::grid(side, side, pitch_m),
                          .scene = {},
                          .estimator = {.method = method},
                          .alerts = {},
                          .friction = {}};
  chain.scene.objects = slipd::paper_objects();
  chain.scene.offset_m = 0.002;
  chain.scene.noise = noise;
  return chain;
}

StatisticsByMove drive(const Grasp& grasp, const slipd::TaxelLayout& layout, const slipd::Skin& skin,
                       const Sampling& sensing, const slipd::RandomStream& noise,
                       slipd::EstimatorChain& chain, const std::function<void(const GraspSample&)>& watch) {
  using namespace slipd;
  const auto& object = grasp.contact;
  contact::LoadHistory contact(
      contact::make_body_pair(contact::body_of(skin), {object.radius_m, object.modulus_pa, object.poisson}));
  TrialFrames frames(layout, sensing.kind, sensing.noise);
  FrictionTrace trace(layout, object.x_m, object.y_m);
  std::optional<contact::ImprintSheet> imprint;
  const contact::Imprint felt{.depth_m = skin.depth_m,
                              .bonded_poisson = skin.bonded_poisson(),
                              .stretch = sensing.stretch,
                              .angle_rad = 2 * grasp.direction_rad,  // any to the pull
                              .power = sensing.power};
  if (!felt.plain()) imprint.emplace(layout, felt);
  StatisticsByMove tallies;
  Estimate estimate;
  std::uint64_t sequence = 0;
  for (const LoadSegment& segment : grasp.segments) {
    const double normal_n = contact.normal_n(), shear_n = contact.shear_n();
    const auto steps = static_cast<int>(std::ceil(segment.seconds / sensing.frame_s));
    for (int step = 1; step <= steps; ++step) {
      const double part = static_cast<double>(step) / steps;
      contact.move_to(normal_n + part * (segment.normal_n - normal_n),
                      shear_n + part * (segment.shear_n - shear_n), segment.friction);
      ++sequence;
      const double time_s = static_cast<double>(sequence) * sensing.frame_s;
      const Truth truth{contact.safety_margin(), contact.friction()};
      double taken_us = 0;
      bool traced = true;
      if (!sensing.comes || sensing.comes(sequence)) {
        if (!imprint) frames.feel(contact, object.x_m, object.y_m);
        if (sensing.trace && !imprint) traced = trace.update(contact, shear_sigma_pa(frames, sensing));
        const auto time_ns = static_cast<std::int64_t>(1e9 * time_s);
        Frame frame = imprint ? frames.sense_imprint(*imprint, contact, object.x_m, object.y_m,
                                                     grasp.direction_rad, noise.stream(sequence))
                              : frames.sense(grasp.direction_rad, noise.stream(sequence), sequence, time_ns);
        frame.sequence = sequence;
        frame.time_ns = time_ns;
        if (sensing.spoil) {
          FrameSlot spoilt;
          spoilt.sequence = frame.sequence;
          spoilt.time_ns = frame.time_ns;
          spoilt.normal_pa = frames.sensed_normal_pa();
          spoilt.shear_x_pa = frames.sensed_shear_x_pa();
          spoilt.shear_y_pa = frames.sensed_shear_y_pa();
          sensing.spoil(spoilt);
          frame = spoilt.view();
        }
        const double start_us = thread_us();
        estimate = chain.estimate(frame);
        taken_us = thread_us() - start_us;
        tallies[static_cast<std::size_t>(segment.move)].add(estimate, truth.gamma);
      }
      if (watch)
        watch(
            {time_s, segment.move, contact.normal_n(), contact.shear_n(), truth, estimate, traced, taken_us});
    }
  }
  return tallies;
}

}  // namespace lab
