#include "core/chain/pressure_chain.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/advice/alert.hpp"
#include "core/chain/chain_parts.hpp"
#include "core/chain/contact_pipeline.hpp"
#include "core/chain/pattern_observer.hpp"
#include "core/chain/setup/sensor_kind.hpp"
#include "core/frame/significance.hpp"
#include "core/health/plausibility.hpp"
#include "core/margin/margin_bound.hpp"
#include "core/margin/margin_decision.hpp"
#include "core/patch/contact_gate.hpp"
#include "core/patch/patch.hpp"

namespace slipd {
namespace {

// Refused frames in a row after which what was learnt of the grasp is forgotten: the object may have moved
// meanwhile.
constexpr int kFramesRemembered = 5;
constexpr double kSecondsPerNs = 1e-9;

std::unique_ptr<PatternObserver> make_observer(const ChainSetup& setup) {
  if (setup.layout.size() == 1) return std::make_unique<PatternObserver>();
  return std::make_unique<TaxelPatternObserver>(setup.layout, setup.alerts.false_alarms_per_hour);
}

struct PressureChain final : FrameChain {
  PressureChain(const ChainSetup& setup, const std::shared_ptr<const TrainedModel>& model)
      : pipeline(make_pipeline(setup, model, work_precision)),
        finder(setup.layout, patch_options(setup)),
        plausibility(setup.layout, plausibility_limits(setup)),
        gate(make_contact_gate(setup.layout, setup.sensor_class, setup.contact.min_normal_n)),
        observer(make_observer(setup)),
        alert(setup.alerts),
        sigma_max(setup.estimator.sigma_max),
        slip_below(setup.alerts.slip_below),
        skin_radius_m(setup.scene.skin.radius_m) {}

  Method method() const noexcept override { return pipeline->method(); }
  const WorkPrecision& tradeoff() const noexcept override { return work_precision; }
  bool repeats() const noexcept override { return repeated; }
  std::vector<std::string_view> stages() const override;
  Estimate estimate(const Frame& frame) noexcept override;

  // The frame that is used, its patch, and what speaks against it.
  struct Checked {
    Frame frame;
    const ContactPatch& patch;
    const Judgement& judgement;
  };

  Checked check(const Frame& frame, Estimate& out) noexcept {
    const ContactPatch* patch = &finder.find(frame);
    Frame used = frame;
    if (plausibility.screen(frame, *patch)) {
      used = plausibility.mended(frame);
      patch = &finder.find(used);
    }
    const Judgement& judgement = plausibility.judge(frame, *patch);
    out.health = judgement.health;
    repeated = judgement.repeats;
    return {used, *patch, judgement};
  }

  // Without a zero nothing but the course of the readings means anything.
  void pass_unzeroed(const Frame& frame, MarginDecision& decision, Estimate& out) noexcept {
    last_used = false;
    lose_sight();
    decision.refuse(State::unzeroed);
    observer->observe(frame, false, out);
  }

  // A frame that was used before. It is no new evidence: what was known of the grasp is as old as it was, and
  // only time goes on.
  void repeat(const Checked& checked, Estimate& out) noexcept {
    const Health health = checked.judgement.health;
    const double passed_s = static_cast<double>(out.time_ns - last.time_ns) * kSecondsPerNs;
    last.sequence = out.sequence;
    last.time_ns = out.time_ns;
    if (last.sliding_for_s) *last.sliding_for_s += passed_s;
    if (last.time_to_slip_s) last.time_to_slip_s = std::max(0.0, *last.time_to_slip_s - passed_s);
    out = last;
    if (is_implausible(health)) out.health = health;
    alert.judge(out);
  }

  // Whether the frame is the one before, and that was used.
  bool is_repeated(const Checked& checked) const noexcept { return checked.judgement.repeats && last_used; }

  // A frame that is not used. Memory of the grasp outlives a few of them. After a jump sliding is detected
  // all the same.
  void refuse(const Checked& checked, MarginDecision& decision, Estimate& out) noexcept {
    last_used = false;
    const bool jump = checked.judgement.health == Health::jump;
    refused = std::min(refused + 1, kFramesRemembered + 1);
    if (jump || refused > kFramesRemembered) lose_sight();
    if (jump) {
      gate->judge(checked.frame, checked.patch);
    } else {
      gate->leave();
    }
    if (checked.judgement.verdict == Verdict::sensor_fault) decision.fail();
    decision.refuse(State::out_of_model);
    observer->observe(checked.frame, gate->touching(), out);
  }

  // A frame with a contact or without one.
  void use(const Checked& checked, MarginDecision& decision, Estimate& out) noexcept {
    refused = 0;
    last_used = true;
    const bool touches = gate->judge(checked.frame, checked.patch);
    finder.set_noise(gate->noise());
    if (gate->zero_is_anothers()) return pass_unzeroed(checked.frame, decision, out);
    if (touches) {
      pipeline->estimate(checked.frame, checked.patch, observer->previous(), decision, out);
    } else {
      leave_contact(decision, out);
    }
    decision.leave_out(checked.judgement.left_out_share);
    observer->observe(checked.frame, touches, out);
    if (touches) follow_turn(checked.patch, decision, out);
  }

  // Without pressure to speak of. A contact that pulls at some taxels can still carry shear: a hooked cable.
  // It has no margin, and is not no contact.
  void leave_contact(MarginDecision& decision, Estimate& out) noexcept {
    forget();
    const auto pulled = gate->pulled();
    if (!pulled) return decision.refuse(State::no_contact);
    out.normal_n = pulled->normal_n;
    out.shear_n = pulled->shear_n;
    decision.refuse(State::out_of_model);
    decision.bound(0);
  }

  // How far the object has turned over the skin.
  void follow_turn(const ContactPatch& patch, const MarginDecision& decision, Estimate& out) noexcept {
    const auto margin = decision.margin();
    const bool slides = margin && margin->mean <= kClearSigmas * margin->sigma;
    observer->follow_turn(patch, slides && pipeline->carries_torque(), out);
  }

  // The margin, and what a controller may act on.
  void decide(MarginDecision& decision, Estimate& out) noexcept {
    if (slides(out.sliding)) decision.slide(slip_below);
    decision.apply(out);
    if (out.radius_m && std::isfinite(skin_radius_m)) out.a_over_r = *out.radius_m / skin_radius_m;
    alert.judge(out);
    out.time_to_slip_s = forecast.update(out.time_ns, out.gamma, out.sigma.value_or(0));
    last = out;
  }

  // The contact was lost.
  void forget() noexcept {
    pipeline->forget();
    observer->forget();
  }

  // The contact goes on, or another one has come, and what it does is not seen.
  void lose_sight() noexcept {
    pipeline->lose_sight();
    observer->forget();
  }

  WorkPrecision work_precision;
  std::unique_ptr<ContactPipeline> pipeline;
  PatchFinder finder;
  PlausibilityMonitor plausibility;
  std::unique_ptr<ContactGate> gate;
  std::unique_ptr<PatternObserver> observer;
  AlertLogic alert;
  SlipForecast forecast;
  const double sigma_max, slip_below, skin_radius_m;
  int refused = 0;         // frames in a row
  bool last_used = false;  // the frame before
  Estimate last;           // of the frame before
  bool repeated = false;   // the frame is the one before
};

std::vector<std::string_view> PressureChain::stages() const {
  std::vector<std::string_view> all{"contact_patch", "health", "contact_gate"};
  for (const std::string_view stage : pipeline->stages()) all.push_back(stage);
  if (!observer->name().empty()) all.push_back(observer->name());
  return all;
}

Estimate PressureChain::estimate(const Frame& frame) noexcept {
  Estimate out;
  out.sequence = frame.sequence;
  out.time_ns = frame.time_ns;
  MarginDecision decision(sigma_max, pipeline->least_sigma(), pipeline->refused());
  if (!frame.zeroed) {
    pass_unzeroed(frame, decision, out);
  } else if (const Checked checked = check(frame, out); checked.judgement.verdict >= Verdict::frame_refused) {
    refuse(checked, decision, out);
  } else if (is_repeated(checked)) {
    repeat(checked, out);
    return out;
  } else {
    use(checked, decision, out);
  }
  decide(decision, out);
  return out;
}

}  // namespace

std::unique_ptr<FrameChain> make_pressure_chain(const ChainSetup& setup,
                                                const std::shared_ptr<const TrainedModel>& model) {
  return std::make_unique<PressureChain>(with_sensed_skin(setup), model);
}

}  // namespace slipd
