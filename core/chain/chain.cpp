#include "core/chain/chain.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/advice/alert.hpp"
#include "core/chain/chain_parts.hpp"
#include "core/friction/pad_load_sharing.hpp"
#include "core/friction/unobserved_load_change.hpp"
#include "core/health/plausibility.hpp"
#include "core/margin/margin_fusion.hpp"
#include "core/margin/pad_forces.hpp"
#include "core/margin/skin_force_correction.hpp"
#include "core/patch/contact_gate.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/trained_model.hpp"
#include "core/reading/moments/moments.hpp"
#include "core/reading/torque/equivalent_pull.hpp"
#include "core/reading/torque/torque_reading.hpp"
#include "core/sliding/turned_angle.hpp"

namespace slipd {
namespace {

// Refused frames in a row after which what was learnt of the grasp is forgotten: the object may have moved
// meanwhile.
constexpr int kFramesRemembered = 5;

// Taxels within the contact's disc below which a frame's shape is not used, 4 to 30, except by Fit, which
// uses the whole pad. Too small: the shape is noise. Too large: small contacts get no margin from their
// shape.
constexpr std::size_t kFewInside = 12;

// Standard deviations below a mean that 95 % of a Gaussian lie above.
constexpr double kOneSided95 = 1.645;

// Shear from which on a frame has a shape, in standard deviations; 2 … 6. Too small: methods read noise. Too
// large: light pulls get no margin from their shape.
constexpr double kClearSigmas = 3;

// Of a sensor whose taxels' shear means nothing by itself (flat skin): taxels that carry more than this of P
// against each other, share, 0.05 … 0.5, take the margin away: the object is turned, hooked, or pulled at in
// several places, and the margin of the sum is too safe. Quiet grasps of real pillars reach 0.066; a round
// contact that slipped and was unloaded has 0.45 mu of P locked in (docs/theory.md §4.1). Too small: margins
// come and go. Too large: such a grip is called safe.
constexpr double kMaxInternalShare = 0.25;

}  // namespace

struct EstimatorChain::Impl {
  Impl(const ChainSetup& s, std::shared_ptr<const TrainedModel> m)
      : equivalent_pull(s.layout),
        setup(s),
        model(std::move(m)),
        finder(s.layout, patch_options(s)),
        plausibility(s.layout, plausibility_limits(s)),
        method(s.sensor_class == SensorClass::normal ? nullptr : make_method(s, model, work_precision)),
        closing(make_closing_beside(s)),
        skin_force_correction(s.scene.skin.depth_m > 0),
        pad_forces(make_pad_forces(s)),
        torque_reading(s.layout, s.estimator.tracking),
        pad_load_sharing(make_shared_shear(s)),
        tracker(s.estimator, expected_friction(s.scene), s.friction, weighed_over_time(s),
                tracker_options(s, pad_forces ? &*pad_forces : nullptr)),
        known(s.friction.value_or(expected_friction(s.scene))),
        usual_friction(std::sqrt(known.range.low * known.range.high)),
        sliding(s.layout, s.alerts.false_alarms_per_hour),
        turn(s.layout),
        gate(s.layout, s.sensor_class, s.contact.min_normal_n),
        alert(s.alerts) {}

  // The contact was lost.
  void forget() noexcept {
    tracker.forget();
    unseen.reset();
    equivalent_pull.reset();
    torque_reading.forget();
    if (pad_load_sharing) pad_load_sharing->forget();
    if (method) method->forget();
    if (closing) closing->forget();
    skin_force_correction.forget();
    turn.forget();
  }

  // The contact goes on, or another one has come, and what it does is not seen.
  void lose_sight() noexcept {
    forget();
    equivalent_pull.lose_way();
  }

  // What the forces did since the last frame was not measured: sigma grows with it.
  void widen_by_unseen_motion(const ContactPatch& patch, Estimate& out) noexcept {
    unseen.update(patch, out.friction.value_or(usual_friction));
    unseen.widen(out, setup.estimator.sigma_max);
  }

  // Without pressure to speak of. A contact that pulls at some taxels can still carry shear: a hooked cable.
  // It has no margin, and is not no contact.
  void leave_contact(Estimate& out) noexcept {
    forget();
    if (const auto& pulled = gate.pulled()) {
      out.normal_n = pulled->normal_n;
      out.shear_n = pulled->shear_n;
      out.state = State::out_of_model;
      out.gamma_low = 0;
      return;
    }
    out.state = setup.sensor_class == SensorClass::normal ? State::no_shear : State::no_contact;
  }

  // Whether the object slides; `contact` is ignored for frames without a zero.
  void detect_sliding(const Frame& frame, bool contact, Estimate& out) noexcept {
    course = sliding.update(frame, contact);
    out.sliding = course.sliding;
    if (course.sliding) out.sliding_for_s = course.for_s;
  }

  // How far the object has turned over the skin.
  void follow_turn(const ContactPatch& patch, Estimate& out) noexcept {
    const bool slides_turning =
        turning != Turning::none && out.gamma && *out.gamma <= kClearSigmas * out.sigma.value_or(0);
    const auto turned = turn.update(out.time_ns, patch, course.field.settled, slides_turning);
    if (!turned) return;
    out.turned_rad = turned->angle_rad;
    out.turned_sigma_rad = turned->sigma_rad;
  }

  // What friction is not below, with 95 % confidence.
  double least_friction(const Estimate& out) const noexcept {
    if (!out.friction) return known.range.low;
    return std::max(known.range.low, *out.friction - kOneSided95 * out.friction_sigma.value_or(0));
  }

  // The margin on the safe side of all that is not known. `loaded`: with the pull of force and torque.
  void bound_margin(const ContactPatch& patch, const ContactPatch& loaded, Estimate& out) const noexcept {
    const double friction = least_friction(out);
    const double normal_n = patch.normal_n - kOneSided95 * patch.normal_sigma_n;
    out.limit_low_n = std::max(0.0, friction * normal_n);
    // As if what taxels carry against each other came on top: no more than that is used up of friction.
    // Torque is a part of it.
    const double internal_n = method ? 0 : course.field.internal_share * patch.normal_n;
    const double in_common = pad_forces ? pad_forces->ratio_sigma() : 0;
    const double shear_n = (1 + kOneSided95 * in_common) *
                           std::max(loaded.shear_n + kOneSided95 * loaded.shear_sigma_n,
                                    patch.shear_n + kOneSided95 * patch.shear_sigma_n + internal_n);
    double low = normal_n > 0 ? std::clamp(1 - shear_n / (friction * normal_n), 0.0, 1.0) : 0;
    if (out.gamma) low = std::clamp(*out.gamma - kOneSided95 * out.sigma.value_or(0), 0.0, low);
    // Under a skin the disc feels less of the shear than of the pressure.
    const bool felt_less = setup.scene.skin.depth_m > 0 && !skin_force_correction.known() && !out.gamma;
    out.gamma_low = felt_less && patch.shear_n > kClearSigmas * patch.shear_sigma_n ? 0 : low;
  }

  // A frame that is not used. Memory of the grasp outlives a few of them. After a jump sliding is detected
  // all the same.
  void refuse(const Judgement& judgement, const Frame& frame, const ContactPatch& patch,
              Estimate& out) noexcept {
    refused = std::min(refused + 1, kFramesRemembered + 1);
    if (judgement.health == Health::jump || refused > kFramesRemembered) lose_sight();
    if (judgement.health == Health::jump) {
      gate.judge(frame, patch);
    } else {
      gate.leave();
    }
    if (judgement.verdict == Verdict::sensor_fault) {
      out.state = State::fault;
    } else {
      out.state = setup.sensor_class == SensorClass::normal ? State::no_shear : State::out_of_model;
    }
  }

  // Of taxels whose shear means nothing by itself (flat skin) only the change of torque since the contact
  // settled is a load: pressing makes one as well, and it grows with P.
  ContactPatch without_pressing(const ContactPatch& patch) const noexcept {
    ContactPatch pulled = patch;
    if (method || setup.layout.size() == 1) return pulled;
    pulled.torque_nm =
        course.field.settled ? patch.torque_nm - course.field.pressing_lever_m * patch.normal_n : 0;
    return pulled;
  }

  // A frame with a contact or without one.
  void estimate_frame(const Frame& frame, const ContactPatch& patch, Estimate& out) noexcept {
    const bool touches = gate.judge(frame, patch);
    finder.set_noise(gate.noise());
    if (!touches) return leave_contact(out);
    out.normal_n = patch.normal_n;
    if (setup.layout.size() > 1) {
      out.center_x_m = patch.center_x_m;
      out.center_y_m = patch.center_y_m;
      out.radius_m = patch.radius_m;
    }
    if (setup.sensor_class == SensorClass::normal) {
      out.state = State::no_shear;
      return;
    }
    if (method) method->observe(frame, patch);
    if (closing) closing->observe(frame, patch);
    out.shear_n = patch.shear_n;
    out.shear_x_n = patch.shear_x_n;
    out.shear_y_n = patch.shear_y_n;
    const EquivalentPullResult load = equivalent_pull.of(without_pressing(patch), tracker.friction());
    turning = load.turning;
    // What friction has to carry, with torque, as a pull.
    ContactPatch loaded = patch;
    loaded.shear_n = load.pull_n;
    loaded.shear_sigma_n = load.pull_sigma_n;
    out.pull_n = load.pull_n;
    if (setup.layout.size() > 1) {
      out.torque_nm = patch.torque_nm;
      out.torque_sigma_nm = patch.torque_sigma_nm;
    }
    const bool flat_pad = !method && setup.layout.size() > 1;
    const ContactPatch acting = estimate_margin(frame, patch, flat_pad ? patch : loaded, load, out);
    if (flat_pad) {
      out.pull_n = patch.shear_n;
      judge_torque(patch, loaded, out);
    }
    const bool acts = setup.scene.skin.depth_m > 0 && skin_force_correction.known();
    bound_margin(acts ? acting : patch, acts ? acting : loaded, out);
    advise(out, loaded.shear_sigma_n, setup.alerts.target_margin);
  }

  // Pressing makes a torque on a flat pad as well, most where the object is held off its middle. A torque
  // that is no larger than on real pads is left to gamma_low; with a larger one there is no margin.
  void judge_torque(const ContactPatch& patch, const ContactPatch& loaded, Estimate& out) const noexcept {
    // Of what the contact carries, 0.1 … 0.5; quiet grasps of real pillars reach 0.27. Too small: such grasps
    // lose their margin. Too large: margins under a torque are too safe.
    constexpr double kByPressing = 0.3;
    const double carried_n = out.friction.value_or(usual_friction) * patch.normal_n;
    if (!out.gamma || loaded.shear_n - patch.shear_n <= kByPressing * carried_n) return;
    refuse_margin(State::out_of_model, out);
  }

  // By the method, or where it refuses the frame or has a greater sigma by the pressures of the closing. A
  // contact of the model's shape that the method refuses has another history, of which closing shows no more.
  Reading estimate_pull(const Frame& frame, const ContactPatch& patch) noexcept {
    // Sigma by the method's contact model from which on closing may give a better margin; Gamma, 0.02 … 0.1.
    // Too small: two methods run for one margin. Too large: ellipses get an imprecise margin. Under a skin,
    // which hides most of another shape, 0.005 … 0.02.
    constexpr double kUnlikeSigma = 0.03, kUnlikeFelt = 0.01;
    const bool felt = setup.scene.skin.depth_m > 0;
    shape_by = method->name();
    Reading estimate = method->estimate(frame, patch);
    if (!closing || (!felt && estimate.in_model && estimate.common_sigma < kUnlikeSigma)) return estimate;
    const double unlike = felt ? estimate.shape_sigma : moment_ratio(patch, setup.layout).deviation.sigma();
    if (unlike < (felt ? kUnlikeFelt : kUnlikeSigma)) return estimate;
    Reading by_closing = closing->estimate(frame, patch);
    const bool moments_by_closing = std::isfinite(by_closing.moments_sigma.slip_moment_n);
    if (!by_closing.in_model || (!felt && estimate.in_model && estimate.sigma < by_closing.sigma)) {
      if (moments_by_closing) estimate.take_moments(by_closing);
      return estimate;
    }
    shape_by = closing->name();
    if (!moments_by_closing) by_closing.take_moments(estimate);
    return by_closing;
  }

  // One frame by itself: by the method, or as one that a torque has bent.
  Reading estimate_shape(const Frame& frame, const ContactPatch& patch, const ContactPatch& loaded,
                         const EquivalentPullResult& load) noexcept {
    return torque_reading.bent(load) ? torque_reading.estimate(loaded, load) : estimate_pull(frame, patch);
  }

  // Returns the patch with the forces that act.
  ContactPatch estimate_margin(const Frame& frame, const ContactPatch& patch, const ContactPatch& loaded,
                               const EquivalentPullResult& load, Estimate& out) noexcept {
    const bool few = weighed_over_time(setup);
    // So few taxels have no shape under torque.
    const bool shaped =
        method && (patch.count >= kFewInside || few) &&
        (load.turning == Turning::bending ? !few : patch.shear_n > kClearSigmas * patch.shear_sigma_n);
    shape_by = method ? method->name() : Method::friction;
    const Reading reading = shaped ? estimate_shape(frame, patch, loaded, load) : Reading{};
    const ContactPatch acting =
        pad_forces ? skin_force_correction.of_pad(pad_forces->of(patch, reading), patch, loaded, out)
                   : skin_force_correction.of(patch, loaded, reading, out);
    tracker.update(acting, shaped ? &reading : nullptr, shape_by, out, course,
                   pad_load_sharing ? &pad_load_sharing->update(frame, patch) : nullptr);
    const bool given_value = setup.friction && setup.friction->is_value();  // needs no history
    if (setup.estimator.tracking && !given_value) widen_by_unseen_motion(patch, out);
    if (!method && course.field.internal_share > kMaxInternalShare) refuse_margin(State::out_of_model, out);
    if (setup.scene.skin.depth_m > 0 && out.gamma && !skin_force_correction.known()) {
      refuse_margin(State::out_of_model, out);
      out.friction.reset();
      out.friction_sigma.reset();
    }
    if (reading.in_model && !reading.turning) {
      out.center_x_m = reading.center_x_m;
      out.center_y_m = reading.center_y_m;
      out.radius_m = reading.radius_m;
    }
    return acting;
  }

  // No margin, and why.
  static void refuse_margin(State why, Estimate& out) noexcept {
    out.state = why;
    out.gamma.reset();
    out.sigma.reset();
  }

  // Adds the share of the force that neighbours stand for to the margin's sigma.
  void widen(double left_out_share, Estimate& out) const noexcept {
    if (out.gamma_low) *out.gamma_low = std::max(0.0, *out.gamma_low - kOneSided95 * left_out_share);
    if (!out.sigma || left_out_share <= 0) return;
    out.sigma = std::hypot(*out.sigma, left_out_share);
    if (*out.sigma > setup.estimator.sigma_max) refuse_margin(State::learning, out);
  }

  EquivalentPull equivalent_pull;  // first: aligned to a cache line
  ChainSetup setup;
  std::shared_ptr<const TrainedModel> model;
  WorkPrecision work_precision;
  PatchFinder finder;
  PlausibilityMonitor plausibility;
  int refused = 0;                     // frames in a row
  Method shape_by = Method::friction;  // what this frame's own margin is by
  Turning turning = Turning::none;     // of the last frame
  std::unique_ptr<SlipMethod> method;
  std::unique_ptr<SlipMethod> closing;  // of `auto`, for frames that do not fit the method; else null
  SkinForceCorrection skin_force_correction;
  std::optional<PadForces> pad_forces;  // of few taxels under a skin
  TorqueReading torque_reading;
  std::unique_ptr<PadLoadSharing> pad_load_sharing;  // of flat skins of unknown friction; else null
  MarginFusion tracker;
  UnobservedLoadChange unseen;
  KnownFriction known;    // given, else what the scene expects
  double usual_friction;  // while that of the grasp is not known
  SlidingDetector sliding;
  SlidingVerdict course;  // of the last frame
  TurnFollower turn;
  ContactGate gate;
  AlertLogic alert;
  SlipForecast forecast;
};

EstimatorChain::EstimatorChain(const ChainSetup& setup, std::shared_ptr<const TrainedModel> model)
    : impl_(std::make_unique<Impl>(with_felt_skin(setup), std::move(model))) {}
EstimatorChain::EstimatorChain(EstimatorChain&&) noexcept = default;
EstimatorChain& EstimatorChain::operator=(EstimatorChain&&) noexcept = default;
EstimatorChain::~EstimatorChain() = default;

const WorkPrecision& EstimatorChain::tradeoff() const noexcept {
  return impl_->work_precision;
}

Method EstimatorChain::method() const noexcept {
  return impl_->method ? impl_->method->name() : Method::friction;
}

Estimate EstimatorChain::estimate(const Frame& frame) noexcept {
  auto& in = *impl_;
  Estimate out;
  out.sequence = frame.sequence;
  out.time_ns = frame.time_ns;
  if (!frame.zeroed) {
    in.lose_sight();
    out.state = in.setup.sensor_class == SensorClass::normal ? State::no_shear : State::unzeroed;
    in.detect_sliding(frame, false, out);
    in.alert.judge(out);
    out.time_to_slip_s = in.forecast.update(frame.time_ns, std::nullopt, 0);
    return out;
  }
  const ContactPatch* patch = &in.finder.find(frame);
  Frame used = frame;
  if (in.plausibility.screen(frame, *patch)) {
    used = in.plausibility.mended(frame);
    patch = &in.finder.find(used);
  }
  const Judgement& judgement = in.plausibility.judge(frame, *patch);
  out.health = judgement.health;
  if (judgement.verdict >= Verdict::frame_refused) {
    in.refuse(judgement, used, *patch, out);
  } else {
    in.refused = 0;
    in.estimate_frame(used, *patch, out);
    in.widen(judgement.left_out_share, out);
  }
  if (const double skin_m = in.setup.scene.skin.radius_m; out.radius_m && std::isfinite(skin_m))
    out.a_over_r = *out.radius_m / skin_m;
  in.detect_sliding(used, in.gate.touching(), out);
  if (in.refused == 0 && in.gate.touching()) in.follow_turn(*patch, out);
  in.alert.judge(out);
  out.time_to_slip_s = in.forecast.update(frame.time_ns, out.gamma, out.sigma.value_or(0));
  return out;
}

}  // namespace slipd
