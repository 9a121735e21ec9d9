// Whether something touches a sensor: force and shear against the noise that the sensor has without load,
// with hysteresis. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <memory>
#include <optional>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/patch/unloaded_noise.hpp"

namespace slipd {

// Checked with `slipd-bench`.
struct ContactGateOptions {
  // Once in contact, it lasts down to this share of the threshold; 0.2 … 0.9. Too near 1: a light contact
  // comes and goes. Too small: a released object is a contact for longer.
  double kept_share = 0.5;
};

// P below which a sensor is not in contact, N, if none is configured: of sensors of at most kFewTaxels
// taxels, and of one force vector, 0.1, which their zeros wander by; of larger arrays 0, for their free
// taxels show the noise of each frame.
double default_min_normal_n(const TaxelLayout& layout) noexcept;

// Forces of a contact without pressure to speak of: hooked, or pulled. Sums over all taxels, N.
struct PulledForces {
  double normal_n = 0;
  double shear_n = 0;
};

// Of an array, whose free taxels show the noise of each frame: it shows pressure where anything hooks.
class ContactGate {
 public:
  // min_normal_n: P below which nothing touches, N, >= 0.
  explicit ContactGate(double min_normal_n, const ContactGateOptions& options = {})
      : options_(options), min_normal_n_(min_normal_n) {}
  virtual ~ContactGate() = default;

  // One frame with a zero, in order of time, and its patch. True: it is a contact.
  virtual bool judge(const Frame& frame, const ContactPatch& patch) noexcept;

  // A frame that says nothing: the contact counts as lost.
  void leave() noexcept { touching_ = false; }

  bool touching() const noexcept { return touching_; }
  // Of the last frame that was judged; none: it was a contact with pressure, or nothing pulls.
  virtual std::optional<PulledForces> pulled() const noexcept { return std::nullopt; }
  // Whether the zero is plainly another's: since the first frame there is shear without pressure, and no
  // frame was free. A pull at a hooked contact begins in a frame that is not the first.
  virtual bool zero_is_anothers() const noexcept { return false; }
  // What the sensor's noise is without load, of sensors of few taxels; none: not known.
  virtual std::optional<SensorNoise> noise() const noexcept { return std::nullopt; }

 protected:
  // Noise of P that may be taken for a contact, N.
  virtual double normal_noise_n() const noexcept { return 0; }

  const ContactGateOptions options_;
  const double min_normal_n_;

 private:
  bool touching_ = false;
};

// Of few taxels, and of one force vector: noise is known from frames without load.
class FewTaxelsGate final : public ContactGate {
 public:
  FewTaxelsGate(const TaxelLayout& layout, SensorClass sensor_class, double min_normal_n,
                const ContactGateOptions& options = {});
  bool judge(const Frame& frame, const ContactPatch& patch) noexcept override;
  std::optional<PulledForces> pulled() const noexcept override { return pulled_; }
  bool zero_is_anothers() const noexcept override { return zero_is_anothers_; }
  std::optional<SensorNoise> noise() const noexcept override { return noise_.now(); }

 private:
  double normal_noise_n() const noexcept override;
  PulledForces forces_on(const Frame& frame) const noexcept;
  double pull_threshold_n() const noexcept;

  const double area_m2_;
  const bool shows_shear_;
  const double unloaded_n_;  // |P| and |Q| up to which the sensor is not loaded
  UnloadedNoise noise_;
  std::optional<PulledForces> pulled_;
  bool first_ = true, zero_is_anothers_ = false;
};

// min_normal_n: configured, >= 0 N; none: default_min_normal_n.
std::unique_ptr<ContactGate> make_contact_gate(const TaxelLayout& layout, SensorClass sensor_class,
                                               std::optional<double> min_normal_n,
                                               const ContactGateOptions& options = {});

}  // namespace slipd
