#include "daemon/pipeline/estimate_loop.hpp"

#include <algorithm>
#include <utility>

namespace slipd {
namespace {

using Clock = Doorbell::Clock;
constexpr std::chrono::milliseconds kLongestSleep{200};
// Free places of the queue of events below which io is woken to empty it. Fewer: events may be lost while io
// is busy.
constexpr std::size_t kFewFreeEvents = 1024;
// While clients may read the heartbeat: half of its period leaves as much for a round and for waking.
constexpr std::chrono::nanoseconds kLongestSleepShared{board_layout::kHeartbeatPeriodNs / 2};
// Longest estimate that an acquire thread makes itself, ns. Shorter: the estimate thread is woken for more of
// them. Longer: a device waits longer to be read, and frames of other devices with it.
constexpr std::int64_t kLongestHereNs = 100'000;
// Time after which an acquire thread begins no more estimates of others' frames, ns. Less: the estimate
// thread is woken more often. More: its device waits longer to be read.
constexpr std::int64_t kLongestTurnNs = 200'000;
// Least time between frames of a device, in estimates, at which its acquire thread makes them. Less: the
// device is read late when estimates take longer than usual. More: the estimate thread is woken more often.
constexpr std::int64_t kLeastIntervals = 3;
constexpr std::int64_t kAnyIntervalNs = kLeastIntervals * kLongestHereNs;
// How often an acquire thread looks at all sensors for frames that came while it estimated, before it leaves
// them to the estimate thread.
constexpr int kMostLooks = 2;
// How much later than it meant to the estimate thread may wake before acquire threads stop to estimate, ns,
// so that a hanging one is seen at every door. Less: a busy machine stops them. More: it is seen later.
constexpr std::int64_t kThreadGraceNs = 100'000'000;
// Frames over which the time of an estimate is averaged. Fewer: one frame that was interrupted counts as long
// work. More: a change is seen later.
constexpr std::int64_t kFramesOfMean = 16;

std::int64_t monotonic_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

// FLANN allocates in each query (paper/neighbours/neighbours.hpp), which only the estimate thread may do.
bool may_be_made_anywhere(Method method) noexcept {
  return method != Method::svd_knn && method != Method::registered;
}

// At least three frames of a device that defines a slower rate, unless stale_after was configured.
std::int64_t stale_after_ns(const SensorRuntime& runtime, const EstimatorInstance& instance) noexcept {
  const auto set_ns = std::chrono::nanoseconds(runtime.settings.stale_after).count();
  const double rate_hz = instance.feed->info.rate_hz;
  if (runtime.settings.stale_after_configured || !(rate_hz > 0)) return set_ns;
  return std::max(set_ns, static_cast<std::int64_t>(3e9 / rate_hz));
}

}  // namespace

EstimateLoop::EstimateLoop(Board& board, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
                           const std::vector<std::size_t>& sensors, const AlertSettings& alerts,
                           Doorbell* output)
    : board_(board),
      log_(board.logs.emplace_back()),
      events_(board.events.emplace_back()),
      shared_(board.shared),
      output_(output),
      grasp_evaluator_(board, sensors, alerts, shared_),
      states_(sensors.size()),
      places_(runtimes.size()) {
  for (std::size_t place = 0; place < sensors.size(); ++place) {
    states_[place].sensor = sensors[place];
    states_[place].runtime = runtimes[sensors[place]].get();
    places_[sensors[place]] = place;
  }
}

void EstimateLoop::run(const std::atomic<bool>& stop) noexcept {
  adopt_alerts();
  std::uint64_t requests = 0;
  for (;;) {
    const std::uint32_t rung = bell_.ring_count();  // before `stop`: a later stop ends the wait
    const bool ends = stop.load(std::memory_order_relaxed);
    auto wake_at = Clock::now() + kLongestSleepShared;  // if another thread estimates: it rings
    bool busy = false;
    if (turn_.ask_for_thread(requests)) {
      if (ends) break;  // and keeps the turn: nobody estimates any more
      busy = round(wake_at);
      wake_at_ns_ = wake_at.time_since_epoch() / std::chrono::nanoseconds(1);
      if (!turn_.done(requests)) {  // frames were delivered meanwhile
        turn_.hand_over();
        busy = true;
      }
      heartbeat_.fetch_add(1, std::memory_order_relaxed);
    }
    if (!busy) bell_.wait(rung, wake_at);
  }
  for (SensorState& state : states_) adopt_instance(state, nullptr);
}

// The board may have alerts of the configuration before. Without the turn: acquire threads take it only after
// this thread has made an estimate.
void EstimateLoop::adopt_alerts() noexcept {
  for (SensorState& state : states_) {
    state.published = state.runtime->status.latest.load();
    grasp_evaluator_.mark_updated(state.sensor);
  }
}

// Looks at all its sensors; true if there was a frame. `wake_at`: when to look again if nothing rings.
bool EstimateLoop::round(Clock::time_point& wake_at) noexcept {
  bool busy = false;
  bool new_memory = false;
  const auto now = Clock::now();
  std::int64_t now_ns = now.time_since_epoch() / std::chrono::nanoseconds(1);
  const bool shared = shared_.begin_round(now_ns, new_memory);
  if (new_memory) publish_shared();
  wake_at = now + (shared ? kLongestSleepShared : std::chrono::nanoseconds(kLongestSleep));
  for (SensorState& state : states_) {
    if (process(state, now_ns)) {
      busy = true;
      now_ns = state.published.estimate.published_ns;  // one reading of the clock for each frame
    }
    if (!state.no_data && state.instance != nullptr) {
      const std::chrono::nanoseconds deadline(state.idle_since_ns +
                                              stale_after_ns(*state.runtime, *state.instance));
      wake_at = std::min(wake_at, Clock::time_point(deadline));
    }
  }
  evaluate_grasps();
  return busy;
}

void EstimateLoop::evaluate_grasps() noexcept {
  if (!grasp_evaluator_.evaluate()) return;
  board_.io_wakeup.notify();
  if (output_ != nullptr) output_->ring();
}

bool EstimateLoop::is_short(const SensorState& state, std::int64_t interval_ns) const noexcept {
  const std::int64_t estimate_ns = state.estimate_ns.load(std::memory_order_relaxed);
  return estimate_ns > 0 && estimate_ns < kLongestHereNs && estimate_ns * kLeastIntervals < interval_ns;
}

void EstimateLoop::frame_delivered(std::size_t sensor, std::int64_t interval_ns) noexcept {
  SensorState& own = states_[places_[sensor]];
  std::uint64_t requests = 0;
  if (!is_short(own, interval_ns)) return bell_.ring();
  if (!turn_.ask(requests)) return;
  const std::int64_t now_ns = monotonic_ns();
  if (now_ns > wake_at_ns_ + kThreadGraceNs) {  // it hangs: nobody would tell of stale sensors
    turn_.hand_over();
    return bell_.ring();
  }
  estimate_here(own, now_ns);
  evaluate_grasps();
  for (int looks = 0; !turn_.done(requests); ++looks) {
    bool left = EstimateTurn<>::thread_asks(requests) || looks == kMostLooks;
    for (SensorState& state : states_) {
      if (left) break;
      if (state.instance == nullptr || !state.instance->feed->mailbox.has_unread()) continue;
      const std::int64_t later_ns = monotonic_ns();
      if (is_short(state, kAnyIntervalNs) && later_ns - now_ns < kLongestTurnNs) {
        estimate_here(state, later_ns);
      } else {
        left = true;
      }
    }
    evaluate_grasps();
    if (!left) continue;
    turn_.hand_over();
    return bell_.ring();
  }
}

// A frame that has been delivered, in an acquire thread, which has the turn.
void EstimateLoop::estimate_here(SensorState& state, std::int64_t now_ns) noexcept {
  if (!process(state, now_ns) || state.instance == nullptr) return;
  // The estimate thread sleeps longer than this sensor's frames may be late: it slept on another's, or
  // without any.
  if (now_ns + stale_after_ns(*state.runtime, *state.instance) < wake_at_ns_) bell_.ring();
}

// Writes all its estimates into shared memory that io has just made.
void EstimateLoop::publish_shared() noexcept {
  for (const SensorState& state : states_) publish_shared(state);
  grasp_evaluator_.publish_shared();
}

void EstimateLoop::publish_shared(const SensorState& state) noexcept {
  const bool simulated = state.runtime->status.simulated.load(std::memory_order_relaxed);
  if (shared_.publish_sensor(state.sensor, state.published.estimate, simulated)) board_.io_wakeup.notify();
}

// One round for one sensor; true if there was a frame.
bool EstimateLoop::process(SensorState& state, std::int64_t now_ns) noexcept {
  // The link before the mailbox: a recording's last frame is published before the link becomes ended.
  const DeviceLink link = state.runtime->status.link.load(std::memory_order_acquire);
  // The load first: an exchange would take the cache line at each frame. Relaxed: the exchange orders.
  if (state.runtime->incoming.load(std::memory_order_relaxed) != nullptr)
    adopt_instance(state, state.runtime->incoming.exchange(nullptr, std::memory_order_acq_rel));
  const FrameSlot* slot = state.instance != nullptr ? state.instance->feed->mailbox.take() : nullptr;
  if (slot != nullptr) {
    estimate_frame(state, *slot, now_ns);
  } else {
    publish_no_data(state, link, now_ns);
  }
  if (state.event_pending) push_event(state, true);
  if (state.runtime->status.frame_copy.fill_if_requested(state.held)) board_.io_wakeup.notify();
  return slot != nullptr;
}

void EstimateLoop::estimate_frame(SensorState& state, const FrameSlot& slot, std::int64_t now_ns) noexcept {
  FrameFeed& feed = *state.instance->feed;
  if (feed.paced) feed.taken.ring();
  state.held = &slot;
  state.idle_since_ns = now_ns;
  state.no_data = false;
  Published& published = state.published;
  const Frame frame = slot.view();
  state.instance->chain.set_releasing(
      now_ns < state.runtime->status.releasing_until_ns.load(std::memory_order_relaxed));
  published.estimate = state.instance->chain.estimate(frame);
  if (state.instance->chain.repeats()) state.runtime->status.repeated.fetch_add(1, std::memory_order_relaxed);
  published.estimate.sequence = slot.sequence;
  published.estimate.time_ns = slot.time_ns;
  published.estimate.truth = slot.truth;
  count_health(state);
  tell_zero(state, frame.zeroed);
  const ArrivalCounts& arrivals = feed.mailbox.arrivals();
  published.counts.skipped += arrivals.received - published.counts.received - 1;
  published.counts.received = arrivals.received;
  published.counts.gaps = arrivals.gaps;
  published.counts.lost = arrivals.lost;
  ++published.counts.estimated;
  publish(state);
  state.runtime->status.latency.record(published.estimate.published_ns - slot.time_ns);
  if (!may_be_made_anywhere(state.instance->method)) return;
  const std::int64_t took_ns = published.estimate.published_ns - now_ns;
  const std::int64_t mean_ns = state.estimate_ns.load(std::memory_order_relaxed);
  state.estimate_ns.store(mean_ns == 0 ? took_ns : mean_ns + (took_ns - mean_ns) / kFramesOfMean,
                          std::memory_order_relaxed);
}

// Counts an implausible frame, and writes a line when a new reason takes a margin away.
void EstimateLoop::count_health(SensorState& state) noexcept {
  const Estimate& estimate = state.published.estimate;
  const Health before = std::exchange(state.last_health, estimate.health);
  if (!is_implausible(estimate.health)) return;
  SensorStatus& status = state.runtime->status;
  status.implausible[static_cast<std::size_t>(estimate.health)].fetch_add(1, std::memory_order_relaxed);
  if (estimate.health == before || estimate.state != State::fault) return;
  log_.write(LogLevel::warning, {status.name, Cause::device}, "%s: %s", status.name.c_str(),
             describe(estimate.health));
}

// Writes a line when the chain finds out that the zero of these frames is another's.
void EstimateLoop::tell_zero(SensorState& state, bool zeroed) noexcept {
  const bool anothers = zeroed && state.published.estimate.state == State::unzeroed;
  if (std::exchange(state.zero_is_anothers, anothers) == anothers || !anothers) return;
  const std::string& name = state.runtime->status.name;
  log_.write(LogLevel::warning, {name, Cause::configuration}, "%s: %s", name.c_str(), kZeroIsAnothers);
}

// There is no new frame. Publishes the state stale, fault or learning once, when it begins.
void EstimateLoop::publish_no_data(SensorState& state, DeviceLink link, std::int64_t now_ns) noexcept {
  const SensorRuntime& runtime = *state.runtime;
  const bool late =
      state.instance != nullptr && now_ns - state.idle_since_ns >= stale_after_ns(runtime, *state.instance);
  State now = State::stale;
  if (link == DeviceLink::absent || runtime.refused.load(std::memory_order_relaxed)) {
    now = State::fault;
  } else if (link != DeviceLink::ended && !late) {
    if (state.instance != nullptr || link != DeviceLink::open) return;
    now = State::learning;  // its estimator is being made
  }
  const bool known =
      now == state.published.estimate.state && (state.no_data || state.published.counts.estimated == 0);
  state.no_data = true;
  if (known) return;
  if (late && now == State::stale) {
    log_.write(LogLevel::warning, {runtime.status.name, Cause::device}, "%s: no frame for %d ms: stale",
               runtime.status.name.c_str(),
               static_cast<int>(stale_after_ns(runtime, *state.instance) / 1'000'000));
  }
  Estimate no_data;
  no_data.sequence = state.published.estimate.sequence;
  no_data.time_ns = state.published.estimate.time_ns;
  no_data.method = state.instance != nullptr ? state.instance->chain.method() : Method::none;
  no_data.state = now;
  no_data.alert = without_frames(state.published.estimate.alert);
  no_data.alert_cause = state.published.estimate.alert_cause;
  state.published.estimate = no_data;
  publish(state);
}

void EstimateLoop::publish(SensorState& state) noexcept {
  state.published.estimate.published_ns = monotonic_ns();
  state.runtime->status.latest.store(state.published);
  publish_shared(state);
  const Estimate& estimate = state.published.estimate;
  const bool changed = estimate.alert != state.last_output_alert || estimate.state != state.last_output_state;
  if (output_ != nullptr && changed) output_->ring();
  grasp_evaluator_.mark_updated(state.sensor);
  state.last_output_alert = estimate.alert;
  state.last_output_state = estimate.state;
  if (state.event_pending) ++state.events_lost;  // this one replaces the one that did not fit
  push_event(state, changed);
}

// Without a subscriber io sleeps while nothing changes: a wake for each frame would be most of what it does.
void EstimateLoop::push_event(SensorState& state, bool changed) noexcept {
  const auto sensor = static_cast<std::uint32_t>(state.sensor);
  state.event_pending = !events_.push(Event{state.published.estimate, sensor, state.events_lost});
  if (state.event_pending) return;
  state.runtime->status.events_lost.fetch_add(state.events_lost, std::memory_order_relaxed);
  state.events_lost = 0;
  const bool wanted = changed || board_.wake_for_each_event.load(std::memory_order_relaxed);
  if (wanted || events_.write_available() < kFewFreeEvents) board_.io_wakeup.notify();
}

void EstimateLoop::adopt_instance(SensorState& state, EstimatorInstance* instance) noexcept {
  if (state.instance != nullptr) state.instance->retired.store(true, std::memory_order_release);
  state.instance = instance;
  state.estimate_ns.store(0, std::memory_order_relaxed);
  state.held = nullptr;
  state.no_data = false;
  state.idle_since_ns = monotonic_ns();
  // Relaxed: an independent value.
  if (instance != nullptr)
    state.runtime->status.stale_after_ns.store(stale_after_ns(*state.runtime, *instance),
                                               std::memory_order_relaxed);
}

}  // namespace slipd
