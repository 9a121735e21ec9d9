// Frames of contacts that are not slipd's own model: what a skin, an object, a sensor or a past may do to
// one. Each flaw has a strength; at its first one the frame is what the model says.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/contact/history.hpp"
#include "core/contact/scene.hpp"
#include "core/estimate/trial_frames.hpp"
#include "core/model/dataset.hpp"

namespace sliplab {

enum class Flaw : std::uint8_t {
  blurred,    // a skin layer over the taxels spreads all stress (Boussinesq's kernel): its depth, mm
  elliptic,   // the contact's axes, long over short; similar ellipses of stick and contact
  tilted,     // pressure 1 + t x/a times Hertz's, shear cut where it exceeds mu p: t
  gains,      // taxels' gains lie uniformly within 1 +- this
  dead,       // share of taxels that read 0
  biased,     // a zero that is off on each shear channel, of the largest p
  cut,        // the contact's middle this far from the pad's, mm
  regripped,  // P raised by this share at constant Q after the load
  unloaded,   // Q fallen by this share of itself after the load; beyond 1 it is reversed
  grown       // the last share of P and Q came together, nothing slipping
};
inline constexpr std::size_t kFlaws = 10;

std::string_view name_of(Flaw flaw) noexcept;
std::string_view strength_of(Flaw flaw) noexcept;  // what its strength is, with the unit
std::vector<double> strengths(Flaw flaw);          // from none up

struct Trial {
  slipd::Frame frame;  // valid until the next one
  double truth;        // 1 - |Q|/(mu P) of the contact, whatever is felt of it
};

class Adversary {
 public:
  // A regular layout.
  Adversary(const slipd::TaxelLayout& layout, slipd::NoiseKind kind, double noise);
  Adversary(const Adversary&) = delete;
  Adversary& operator=(const Adversary&) = delete;
  ~Adversary() = default;

  // Contact `index` of the scene, Gamma uniform in (0, 1) when its load had risen. The same contact for each
  // flaw and strength.
  Trial make(Flaw flaw, double strength, const slipd::Scene& scene, std::uint64_t seed, std::size_t index);

 private:
  double feel(Flaw flaw, double strength, const slipd::contact::LoadHistory& contact,
              const slipd::ContactDraw& at, double turn_rad);
  void blur(std::vector<float>& field, double sigma_m);
  void blur_by_layer(std::vector<float>& field, double depth_m);

  slipd::TaxelLayout layout_;
  slipd::TaxelLayout fine_;  // points in which a contact without closed averages is felt
  slipd::TrialFrames frames_;
  std::vector<float> p_, q_, row_, sum_, part_;  // of the fine points
};

}  // namespace sliplab
