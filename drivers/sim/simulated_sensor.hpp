// A simulated tactile sensor: script → contact with its load history → tractions on the taxels →
// imperfections of a real sensor; the contact's truth is given beside each frame. With a preset other than
// `ideal` the contact is that of effects/realistic_sensor.hpp. It has no clock, thread or socket: the driver,
// device simulators and tests advance its time.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/contact/contact_field.hpp"
#include "core/contact/hertz.hpp"
#include "core/contact/history.hpp"
#include "core/contact/limit_surface.hpp"
#include "core/contact/turning_contact.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "drivers/sim/effects/realistic_sensor.hpp"
#include "drivers/sim/imperfections.hpp"
#include "drivers/sim/script.hpp"

namespace slipd::sim {

struct SensorSettings {
  contact::Body skin{0.01, 0.5e6, 0.45};                                      // the sensor's surface
  contact::Body object{std::numeric_limits<double>::infinity(), 2e11, 0.25};  // default: flat and stiff
  double offset_x_m = 0;                                                      // of the contact's centre, m
  double offset_y_m = 0;                                                      // of the contact's centre, m
  // Of the object's centre of mass beside the contact, m: each tangential force brings the torque force times
  // lever. 0: none.
  double lever_m = 0;
  // Shape of the contact and depth of the taxels. A shape other than round needs preset ideal, several taxels
  // and no torque. The depth is for preset ideal; above 0 it replaces the depth of preset magnetic_skin.
  contact::ContactGeometry imprint;
  std::vector<Phase> cycle;            // the load, at least one phase
  ImperfectionSettings imperfections;  // default: none
  Preset preset = Preset::ideal;       // others: effects/presets.hpp; for layouts of several taxels
};

// Whether a torque ever acts: by a lever or by a phase.
bool turns(const SensorSettings& settings) noexcept;

class SimulatedSensor {
 public:
  // Throws std::invalid_argument as Script does, for a preset other than `ideal` on one taxel, and for torque
  // with such a preset or on one taxel; with preset `ideal`, contact::ContactError for bodies without a
  // Hertzian contact (both flat). A layout of one taxel is one force vector for the whole pad, wherever the
  // contact is.
  SimulatedSensor(TaxelLayout layout, const SensorSettings& settings);

  // All functions below are called from one thread, allocate nothing and do not throw.

  // Advances time; the contact passes every corner of the script.
  void advance(std::chrono::nanoseconds by) noexcept;

  // Replaces the script's normal force by a controller's (N, clamped to 0 … 1000); nothing: the script's
  // again.
  void grip(std::optional<double> normal_n) noexcept;

  // The frame of this moment, the next in sequence. False: it is lost and `out` is unchanged. `out`: spans of
  // the layout's size; time_ns and device_time_ns count from the start.
  bool sample(FrameSlot& out) noexcept;

  // Counts so many frames as sampled and lost.
  void skip(std::uint64_t frames) noexcept { number_ += frames; }

  // The delay of the next frame, ns.
  std::int64_t late_ns() const noexcept { return imperfections_.late_ns(number_); }

  std::chrono::nanoseconds elapsed() const noexcept { return std::chrono::nanoseconds(elapsed_ns_); }
  Truth truth() const noexcept;  // NaN without contact
  // Of preset `ideal`; with any other it has no load. While a torque acts it follows the force alone.
  const contact::LoadHistory& load() const noexcept { return load_; }
  // Null unless the settings have a torque.
  const contact::TurningContact* turning() const noexcept { return turning_.get(); }
  // Null with preset `ideal`.
  const RealisticSensor* realistic() const noexcept { return realistic_.get(); }
  const Imperfections& imperfections() const noexcept { return imperfections_; }
  const TaxelLayout& layout() const noexcept { return layout_; }

 private:
  void apply_target(const LoadTarget& target) noexcept;
  void advance_realistic(std::int64_t from_ns) noexcept;
  void apply_turning(double normal_n, double shear_n, const LoadTarget& target) noexcept;
  // What a tangential force in N asks of friction with its lever, over what it does alone: 1 or more.
  double lever_share(double normal_n) const noexcept;
  void compute_taxels() noexcept;

  TaxelLayout layout_;
  bool one_vector_;
  double offset_x_m_, offset_y_m_, lever_m_;
  Script script_;
  contact::LoadHistory load_;
  std::unique_ptr<contact::TurningContact> turning_;  // of settings that have a torque
  std::unique_ptr<contact::LimitSurface> hertz_;      // of settings that have a lever
  std::unique_ptr<contact::ContactField> imprint_;    // of contacts that are not round or under a skin
  std::unique_ptr<RealisticSensor> realistic_;
  Imperfections imperfections_;
  std::optional<double> grip_n_;
  std::int64_t elapsed_ns_ = 0;
  std::uint64_t number_ = 0;
  // True values of the taxels, kept while the load is constant; across the pull only with a torque or an
  // imprint.
  std::vector<float> normal_pa_, shear_pa_, across_pa_;
  bool moved_ = true;  // the load changed after they were computed
};

}  // namespace slipd::sim
