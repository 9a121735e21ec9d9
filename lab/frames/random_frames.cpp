#include "lab/frames/random_frames.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lab {
namespace {

using namespace slipd;

int steps_of(const LoadSegment& segment, double frame_s) {
  return static_cast<int>(std::ceil(segment.seconds / frame_s));
}

contact::ContactGeometry geometry_of(const Grasp& grasp, const Skin& skin, const Sampling& sampling) {
  return {.depth_m = skin.depth_m,
          .bonded_poisson = skin.bonded_poisson(),
          .stretch = sampling.stretch,
          .angle_rad = 2 * grasp.direction_rad,  // any to the pull
          .power = sampling.power};
}

}  // namespace

RandomFrames::RandomFrames(Grasp grasp, const TaxelLayout& layout, const Skin& skin, const Sampling& sampling,
                           const RandomStream& noise)
    : layout_(layout),
      grasp_(std::move(grasp)),
      sampling_(sampling),
      noise_(noise),
      contact_(contact::make_body_pair(
          contact::body_of(skin),
          {grasp_.contact.radius_m, grasp_.contact.modulus_pa, grasp_.contact.poisson})),
      frames_(layout, sampling.kind, sampling.noise) {
  const contact::ContactGeometry sensed = geometry_of(grasp_, skin, sampling);
  if (!sensed.plain()) field_.emplace(layout, sensed);
}

std::uint64_t RandomFrames::length() const noexcept {
  std::uint64_t frames = 0;
  for (const LoadSegment& segment : grasp_.segments)
    frames += static_cast<std::uint64_t>(steps_of(segment, sampling_.frame_s));
  return frames;
}

bool RandomFrames::next() {
  while (step_ == steps_) {
    if (begun_ == grasp_.segments.size()) return false;
    step_ = 0;
    steps_ = steps_of(grasp_.segments[begun_++], sampling_.frame_s);
    from_normal_n_ = contact_.normal_n();
    from_shear_n_ = contact_.shear_n();
  }
  const LoadSegment& segment = grasp_.segments[begun_ - 1];
  const double part = static_cast<double>(++step_) / steps_;
  contact_.move_to(from_normal_n_ + part * (segment.normal_n - from_normal_n_),
                   from_shear_n_ + part * (segment.shear_n - from_shear_n_), segment.friction);
  const std::uint64_t number = moment_.number + 1;
  moment_ = {.number = number,
             .time_s = static_cast<double>(number) * sampling_.frame_s,
             .move = static_cast<std::size_t>(segment.move),
             .normal_n = contact_.normal_n(),
             .shear_n = contact_.shear_n(),
             .truth = {contact_.safety_margin(), contact_.friction()}};
  return true;
}

FrameSlot& RandomFrames::sense() {
  const ContactDraw& at = grasp_.contact;
  const RandomStream noise = noise_.stream(moment_.number);
  if (field_) {
    frames_.sense_field(*field_, contact_, at.x_m, at.y_m, grasp_.direction_rad, noise);
  } else {
    frames_.sense(contact_, at.x_m, at.y_m);
    frames_.sense(grasp_.direction_rad, noise);
  }
  slot_ = slot_of(frames_, static_cast<std::int64_t>(1e9 * moment_.time_s));
  return slot_;
}

// Uniform noise of half-width w has the standard deviation w/sqrt 3.
GraspFrames::Traced RandomFrames::traced() const {
  if (field_) return {};
  constexpr double kLeastNoise = 1e-6;  // of the largest value: a sensor without noise rounds
  const auto values = sampling_.kind == NoiseKind::sensor ? frames_.normal_pa() : frames_.shear_pa();
  float most_pa = 0;
  for (const float value : values) most_pa = std::max(most_pa, std::fabs(value));
  const double sigma_pa =
      std::max(sampling_.noise, kLeastNoise) * static_cast<double>(most_pa) / std::sqrt(3.0);
  return {&layout_, grasp_.contact.x_m, grasp_.contact.y_m, &contact_, sigma_pa};
}

}  // namespace lab
