// Frames of contacts that deviate from slipd's contact model: by the skin, the object, the sensor or the load
// history. Each perturbation has a strength; at its first strength the frame follows the model.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/contact/history.hpp"
#include "core/contact/scene.hpp"
#include "core/contact/scene_draws.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

enum class Perturbation : std::uint8_t {
  blurred,    // a skin layer above the taxels spreads the stress (Boussinesq's kernel): its depth, mm
  elliptic,   // elliptic contact with a similar stick zone: long axis over short axis
  tilted,     // pressure 1 + t x/a times Hertz's, shear cut where it exceeds mu p: t
  gains,      // taxels' gains are uniform within 1 +- this
  dead,       // share of taxels that read 0
  biased,     // zero offset of each shear channel, of the largest p
  cut,        // distance of the contact's centre from the pad's, mm
  regripped,  // P rises by this share at constant Q after loading
  unloaded,   // Q falls by this share after loading; beyond 1 it reverses
  grown       // this share of P and Q rose together at last, without slip
};
inline constexpr std::size_t kPerturbations = 10;

std::string_view name_of(Perturbation perturbation) noexcept;
std::string_view strength_of(Perturbation perturbation) noexcept;  // quantity and unit of its strength
std::vector<double> strengths(Perturbation perturbation);          // from none up

struct Trial {
  slipd::Frame frame;  // valid until the next make()
  double truth;        // 1 - |Q|/(mu P) of the contact, including force beyond the pad
};

class Adversary {
 public:
  // A regular layout.
  Adversary(const slipd::TaxelLayout& layout, slipd::NoiseKind kind, double noise);
  Adversary(const Adversary&) = delete;
  Adversary& operator=(const Adversary&) = delete;
  ~Adversary() = default;

  // Contact `index` of the scene, Gamma uniform in (0, 1) at the end of loading. The same contact for each
  // perturbation and strength.
  Trial make(Perturbation perturbation, double strength, const slipd::Scene& scene, std::uint64_t seed,
             std::size_t index);

 private:
  double sense(Perturbation perturbation, double strength, const slipd::contact::LoadHistory& contact,
               const slipd::ContactDraw& at, double turn_rad);
  void blur(std::vector<float>& field, double sigma_m);
  void blur_by_layer(std::vector<float>& field, double depth_m);

  slipd::TaxelLayout layout_;
  slipd::TaxelLayout fine_;  // points for the numerical averages of contacts without closed ones
  slipd::TrialFrames frames_;
  std::vector<float> p_, q_, row_, sum_, part_;  // of the fine points
};

}  // namespace lab
