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
std::int64_t stale_after_ns(const Seat& seat, const Lane& lane) noexcept {
  const auto set_ns = std::chrono::nanoseconds(seat.settings.stale_after).count();
  const double rate_hz = lane.feed->info.rate_hz;
  if (seat.settings.stale_after_told || !(rate_hz > 0)) return set_ns;
  return std::max(set_ns, static_cast<std::int64_t>(3e9 / rate_hz));
}

}  // namespace

Estimating::Estimating(Board& board, std::vector<std::unique_ptr<Seat>>& seats, const AlertSettings& alerts,
                       LogRing& log, Doorbell& bell, Doorbell* output)
    : board_(board), log_(log), bell_(bell), output_(output), grasping_(board, alerts), desks_(seats.size()) {
  for (std::size_t i = 0; i < seats.size(); ++i) desks_[i].seat = seats[i].get();
}

void Estimating::run(const std::atomic<bool>& stop) noexcept {
  for (;;) {
    const std::uint32_t rung = bell_.rung();  // first: a stop after the look at it ends the wait
    if (stop.load(std::memory_order_relaxed)) break;
    bool busy = false;
    auto wake_at = Clock::now() + kLongestSleep;
    for (Desk& desk : desks_) {
      busy = work(desk) || busy;
      if (!desk.quiet && desk.lane != nullptr) {
        const std::chrono::nanoseconds deadline(desk.since_ns + stale_after_ns(*desk.seat, *desk.lane));
        wake_at = std::min(wake_at, Clock::time_point(deadline));
      }
    }
    if (grasping_.judge() && output_ != nullptr) output_->ring();
    heartbeat_.fetch_add(1, std::memory_order_relaxed);
    if (!busy) bell_.wait(rung, wake_at);
  }
  for (Desk& desk : desks_) take_lane(desk, nullptr);
}

// One round for one sensor; true if there was a frame.
bool Estimating::work(Desk& desk) noexcept {
  // First the link, then the mailbox: a device that ended has put its last frame there before it said so.
  const Link link = desk.seat->panel.link.load(std::memory_order_acquire);
  if (Lane* lane = desk.seat->incoming.exchange(nullptr, std::memory_order_acq_rel)) take_lane(desk, lane);
  const FrameSlot* slot = desk.lane != nullptr ? desk.lane->feed->mailbox.take() : nullptr;
  if (slot != nullptr) {
    answer(desk, *slot, monotonic_ns());
  } else {
    say_quiet(desk, link, monotonic_ns());
  }
  if (desk.event_owed) push_event(desk);
  if (desk.seat->panel.frame.serve(desk.held)) board_.io.ring();
  return slot != nullptr;
}

void Estimating::answer(Desk& desk, const FrameSlot& slot, std::int64_t now_ns) noexcept {
  Feed& feed = *desk.lane->feed;
  if (feed.paced) feed.taken.ring();
  desk.held = &slot;
  desk.since_ns = now_ns;
  desk.quiet = false;
  Published& reading = desk.reading;
  reading.estimate = desk.lane->chain.estimate(slot.view());
  reading.estimate.sequence = slot.sequence;
  reading.estimate.time_ns = slot.time_ns;
  reading.estimate.truth = slot.truth;
  const Tally& tally = feed.mailbox.tally();
  reading.counts.skipped += tally.received - reading.counts.received - 1;
  reading.counts.received = tally.received;
  reading.counts.gaps = tally.gaps;
  reading.counts.lost = tally.lost;
  ++reading.counts.estimated;
  publish(desk);
  desk.seat->panel.latency.record(reading.estimate.published_ns - slot.time_ns);
}

// No frame: says so on the board, once, when its reason is or becomes one that a client must know.
void Estimating::say_quiet(Desk& desk, Link link, std::int64_t now_ns) noexcept {
  const Seat& seat = *desk.seat;
  const bool late = desk.lane != nullptr && now_ns - desk.since_ns >= stale_after_ns(seat, *desk.lane);
  State state = State::stale;
  if (link == Link::absent || seat.refused.load(std::memory_order_relaxed)) {
    state = State::fault;
  } else if (link != Link::ended && !late) {
    if (desk.lane != nullptr || link != Link::open) return;
    state = State::learning;  // its model is being made
  }
  const bool said =
      state == desk.reading.estimate.state && (desk.quiet || desk.reading.counts.estimated == 0);
  desk.quiet = true;
  if (said) return;
  if (late && state == State::stale) {
    log_.write(LogLevel::warning, {seat.panel.name, Cause::device}, "%s: no frame for %d ms: stale",
               seat.panel.name.c_str(), static_cast<int>(stale_after_ns(seat, *desk.lane) / 1'000'000));
  }
  Estimate quiet;
  quiet.sequence = desk.reading.estimate.sequence;
  quiet.time_ns = desk.reading.estimate.time_ns;
  quiet.method = desk.lane != nullptr ? desk.lane->chain.method() : Method::none;
  quiet.state = state;
  quiet.alert = desk.reading.estimate.alert;  // that nothing comes is no sign of a safer grip
  desk.reading.estimate = quiet;
  publish(desk);
}

void Estimating::publish(Desk& desk) noexcept {
  desk.reading.estimate.published_ns = monotonic_ns();
  desk.seat->panel.latest.store(desk.reading);
  const Estimate& estimate = desk.reading.estimate;
  const bool changed = estimate.alert != desk.said_alert || estimate.state != desk.said_state;
  if (output_ != nullptr && changed) output_->ring();
  grasping_.touch(static_cast<std::size_t>(&desk - desks_.data()));
  desk.said_alert = estimate.alert;
  desk.said_state = estimate.state;
  if (desk.event_owed) ++desk.events_lost;  // the one that found no room is replaced by this one
  push_event(desk);
}

void Estimating::push_event(Desk& desk) noexcept {
  const auto sensor = static_cast<std::uint32_t>(&desk - desks_.data());
  desk.event_owed = !board_.events.push(Event{desk.reading.estimate, sensor, desk.events_lost});
  if (desk.event_owed) return;
  desk.seat->panel.events_lost.fetch_add(desk.events_lost, std::memory_order_relaxed);
  desk.events_lost = 0;
  board_.io.ring();
}

void Estimating::take_lane(Desk& desk, Lane* lane) noexcept {
  if (desk.lane != nullptr) desk.lane->retired.store(true, std::memory_order_release);
  desk.lane = lane;
  desk.held = nullptr;
  desk.quiet = false;
  desk.since_ns = monotonic_ns();
  // Relaxed: a number of its own.
  if (lane != nullptr)
    desk.seat->panel.stale_after_ns.store(stale_after_ns(*desk.seat, *lane), std::memory_order_relaxed);
}

}  // namespace slipd
