// From a frame in contact to its margin: one pipeline for each kind of sensor (sensor_kind.hpp), put together
// once from what that kind needs. A stage asks nothing about the set-up.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "core/chain/setup/setup.hpp"
#include "core/estimate/estimate.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/model_errors.hpp"
#include "core/load/equivalent_pull.hpp"
#include "core/margin/margin_decision.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/trained_model.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

class ContactPipeline {
 public:
  virtual ~ContactPipeline() = default;

  // What reads single frames; friction where nothing does. Any thread.
  virtual Method method() const noexcept = 0;
  // What no margin of this sensor is surer than: standard deviation, Gamma.
  virtual double least_sigma() const noexcept { return kExactShare; }
  // Why there is never a margin; none: there may be.
  virtual std::optional<State> refused() const noexcept { return std::nullopt; }

  // Names of its stages, in order. Set-up.
  virtual std::vector<std::string_view> stages() const = 0;

  // Estimate thread. Allocates nothing. One frame in contact, in order of time: fills in forces, friction and
  // advice, and says to `decision` what it knows of the margin. previous: sliding, a frame ago.
  virtual void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                        MarginDecision& decision, Estimate& out) noexcept = 0;
  // Whether the last frame carried a torque above noise.
  virtual bool carries_torque() const noexcept { return false; }
  // The contact was lost: what was learnt of it is forgotten.
  virtual void forget() noexcept = 0;
  // The contact goes on, or another one has come, and what it does is not seen.
  virtual void lose_sight() noexcept = 0;
};

// Throws std::invalid_argument for a method that this sensor cannot carry, or a model of another layout.
// `work_precision` gets what the choice of `auto` was made by, or what was measured with the model.
std::unique_ptr<ContactPipeline> make_pipeline(const ChainSetup& setup,
                                               const std::shared_ptr<const TrainedModel>& model,
                                               WorkPrecision& work_precision);

// What the patch measures, written to the answer: forces; centre and radius; torque.
void publish_forces(const ContactPatch& patch, Estimate& out) noexcept;
void publish_place(const ContactPatch& patch, Estimate& out) noexcept;
void publish_torque(const ContactPatch& patch, Estimate& out) noexcept;

// The patch with the pull that stands for force and torque.
ContactPatch with_pull(const ContactPatch& patch, const EquivalentPullResult& pull) noexcept;

}  // namespace slipd
