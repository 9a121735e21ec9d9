#include "daemon/pipeline/estimate_loop.hpp"

#include <algorithm>

namespace slipd {
namespace {

using Clock = Doorbell::Clock;
constexpr std::chrono::milliseconds kLongestSleep{200};

std::int64_t monotonic_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

// Never shorter than three frames of a device that dictates a slower rate, unless the user says so.
std::int64_t stale_after_ns(const SensorRuntime& runtime, const EstimatorInstance& instance) noexcept {
  const auto set_ns = std::chrono::nanoseconds(runtime.settings.stale_after).count();
  const double rate_hz = instance.feed->info.rate_hz;
  if (runtime.settings.stale_after_told || !(rate_hz > 0)) return set_ns;
  return std::max(set_ns, static_cast<std::int64_t>(3e9 / rate_hz));
}

}  // namespace

EstimateLoop::EstimateLoop(Board& board, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
                           const AlertSettings& alerts, LogRing& log, Doorbell& bell, Doorbell* output)
    : board_(board),
      log_(log),
      bell_(bell),
      output_(output),
      grasp_evaluator_(board, alerts),
      states_(runtimes.size()) {
  for (std::size_t i = 0; i < runtimes.size(); ++i) states_[i].runtime = runtimes[i].get();
}

void EstimateLoop::run(const std::atomic<bool>& stop) noexcept {
  for (;;) {
    const std::uint32_t rung = bell_.rung();  // first: a stop after the look at it ends the wait
    if (stop.load(std::memory_order_relaxed)) break;
    bool busy = false;
    auto wake_at = Clock::now() + kLongestSleep;
    for (SensorState& state : states_) {
      busy = work(state) || busy;
      if (!state.quiet && state.instance != nullptr) {
        const std::chrono::nanoseconds deadline(state.since_ns +
                                                stale_after_ns(*state.runtime, *state.instance));
        wake_at = std::min(wake_at, Clock::time_point(deadline));
      }
    }
    if (grasp_evaluator_.judge() && output_ != nullptr) output_->ring();
    heartbeat_.fetch_add(1, std::memory_order_relaxed);
    if (!busy) bell_.wait(rung, wake_at);
  }
  for (SensorState& state : states_) take_instance(state, nullptr);
}

// One round for one sensor; true if there was a frame.
bool EstimateLoop::work(SensorState& state) noexcept {
  // First the link, then the mailbox: a device that ended has put its last frame there before it said so.
  const Link link = state.runtime->status.link.load(std::memory_order_acquire);
  if (EstimatorInstance* instance = state.runtime->incoming.exchange(nullptr, std::memory_order_acq_rel))
    take_instance(state, instance);
  const FrameSlot* slot = state.instance != nullptr ? state.instance->feed->mailbox.take() : nullptr;
  if (slot != nullptr) {
    answer(state, *slot, monotonic_ns());
  } else {
    say_quiet(state, link, monotonic_ns());
  }
  if (state.event_owed) push_event(state);
  if (state.runtime->status.frame.serve(state.held)) board_.io.ring();
  return slot != nullptr;
}

void EstimateLoop::answer(SensorState& state, const FrameSlot& slot, std::int64_t now_ns) noexcept {
  FrameFeed& feed = *state.instance->feed;
  if (feed.paced) feed.taken.ring();
  state.held = &slot;
  state.since_ns = now_ns;
  state.quiet = false;
  Published& reading = state.reading;
  reading.estimate = state.instance->chain.estimate(slot.view());
  reading.estimate.sequence = slot.sequence;
  reading.estimate.time_ns = slot.time_ns;
  reading.estimate.truth = slot.truth;
  const Tally& tally = feed.mailbox.tally();
  reading.counts.skipped += tally.received - reading.counts.received - 1;
  reading.counts.received = tally.received;
  reading.counts.gaps = tally.gaps;
  reading.counts.lost = tally.lost;
  ++reading.counts.estimated;
  publish(state);
  state.runtime->status.latency.record(reading.estimate.published_ns - slot.time_ns);
}

// No frame: says so on the board, once, when its reason is or becomes one that a client must know.
void EstimateLoop::say_quiet(SensorState& state, Link link, std::int64_t now_ns) noexcept {
  const SensorRuntime& runtime = *state.runtime;
  const bool late =
      state.instance != nullptr && now_ns - state.since_ns >= stale_after_ns(runtime, *state.instance);
  State now = State::stale;
  if (link == Link::absent || runtime.refused.load(std::memory_order_relaxed)) {
    now = State::fault;
  } else if (link != Link::ended && !late) {
    if (state.instance != nullptr || link != Link::open) return;
    now = State::learning;  // its model is being made
  }
  const bool said =
      now == state.reading.estimate.state && (state.quiet || state.reading.counts.estimated == 0);
  state.quiet = true;
  if (said) return;
  if (late && now == State::stale) {
    log_.write(LogLevel::warning, {runtime.status.name, Cause::device}, "%s: no frame for %d ms: stale",
               runtime.status.name.c_str(),
               static_cast<int>(stale_after_ns(runtime, *state.instance) / 1'000'000));
  }
  Estimate quiet;
  quiet.sequence = state.reading.estimate.sequence;
  quiet.time_ns = state.reading.estimate.time_ns;
  quiet.method = state.instance != nullptr ? state.instance->chain.method() : Method::none;
  quiet.state = now;
  quiet.alert = state.reading.estimate.alert;  // that nothing comes is no sign of a safer grip
  state.reading.estimate = quiet;
  publish(state);
}

void EstimateLoop::publish(SensorState& state) noexcept {
  state.reading.estimate.published_ns = monotonic_ns();
  state.runtime->status.latest.store(state.reading);
  const Estimate& estimate = state.reading.estimate;
  const bool changed = estimate.alert != state.said_alert || estimate.state != state.said_state;
  if (output_ != nullptr && changed) output_->ring();
  grasp_evaluator_.touch(static_cast<std::size_t>(&state - states_.data()));
  state.said_alert = estimate.alert;
  state.said_state = estimate.state;
  if (state.event_owed) ++state.events_lost;  // the one that found no room is replaced by this one
  push_event(state);
}

void EstimateLoop::push_event(SensorState& state) noexcept {
  const auto sensor = static_cast<std::uint32_t>(&state - states_.data());
  state.event_owed = !board_.events.push(Event{state.reading.estimate, sensor, state.events_lost});
  if (state.event_owed) return;
  state.runtime->status.events_lost.fetch_add(state.events_lost, std::memory_order_relaxed);
  state.events_lost = 0;
  board_.io.ring();
}

void EstimateLoop::take_instance(SensorState& state, EstimatorInstance* instance) noexcept {
  if (state.instance != nullptr) state.instance->retired.store(true, std::memory_order_release);
  state.instance = instance;
  state.held = nullptr;
  state.quiet = false;
  state.since_ns = monotonic_ns();
  // Relaxed: a number of its own.
  if (instance != nullptr)
    state.runtime->status.stale_after_ns.store(stale_after_ns(*state.runtime, *instance),
                                               std::memory_order_relaxed);
}

}  // namespace slipd
