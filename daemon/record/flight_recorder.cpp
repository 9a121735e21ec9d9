#include "daemon/record/flight_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <thread>
#include <utility>

#include "core/recording/recording.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/recorded.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kFlightStackBytes = std::size_t{256} * 1024;
// Time between two looks at an empty queue. Longer: the queue must hold more frames. Shorter: more wake-ups.
constexpr auto kFlightPollInterval = 5ms;
// Frames that the queue holds while this thread is late, s. Too short: a loaded machine loses frames.
constexpr double kQueueSeconds = 0.25;
// Rate by which memory is reserved for a device of unknown rate, Hz. A faster device keeps fewer seconds.
constexpr double kUnknownRateHz = 1000;
constexpr auto kStopPatience = 300ms;  // at a stop, for the recordings that clients requested

std::size_t frames_in(double seconds, double rate_hz) {
  return static_cast<std::size_t>(std::ceil(seconds * rate_hz)) + 16;
}

// "left-20261120T235959.123Z"
std::string recording_name(const std::string& sensor) {
  const std::int64_t ms = Now::read().realtime_ns / 1'000'000;
  const auto seconds = static_cast<std::time_t>(ms / 1000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 64> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%S", &utc);
  std::string fraction = std::to_string(1000 + ms % 1000);
  fraction[0] = '.';
  return sensor + "-" + std::string(text.data(), length) + fraction + "Z";
}

}  // namespace

FlightRecorder::FlightRecorder(const RecorderSettings& settings, Board& board)
    : settings_(settings), folder_(recordings_directory(), static_cast<std::size_t>(settings.keep)) {
  for (const auto& status : board.sensors) {
    tracks_.push_back(std::make_unique<Track>());
    tracks_.back()->status = status.get();
  }
}

FlightRecorder::~FlightRecorder() {
  request_stop();
}

void FlightRecorder::start() {
  thread_ = Thread("flight", kFlightStackBytes, [this] { run(); });
}

void FlightRecorder::trigger(std::size_t sensor, Reason reason) noexcept {
  std::atomic<Reason>& at = tracks_[sensor]->trigger_reason;
  Reason before = at.load(std::memory_order_relaxed);
  while (before < reason && !at.compare_exchange_weak(before, reason, std::memory_order_relaxed)) {
  }
}

std::optional<std::uint64_t> FlightRecorder::request(std::size_t sensor) noexcept {
  Track& track = *tracks_[sensor];
  const bool one_is_coming = track.pending.load(std::memory_order_relaxed) ||
                             track.trigger_reason.load(std::memory_order_relaxed) != Reason::none;
  if (!one_is_coming && !track.requests.grant(Clock::now())) return std::nullopt;
  trigger(sensor, Reason::request);
  return track.begun.load(std::memory_order_relaxed) + 1;
}

FlightOutcome FlightRecorder::outcome(std::size_t sensor) const {
  const std::lock_guard lock(outcomes_);
  return tracks_[sensor]->outcome;
}

void FlightRecorder::finish(Track& track, std::string file, std::string trouble) {
  const std::lock_guard lock(outcomes_);
  track.outcome = {track.begun.load(std::memory_order_relaxed), std::move(file), std::move(trouble)};
}

void FlightRecorder::add_estimate(std::size_t sensor, const Estimate& estimate) noexcept {
  tracks_[sensor]->estimates_in.push({.time_ns = estimate.time_ns, .estimate = recorded(estimate)});
}

void FlightRecorder::run() {
  for (bool last = false; !last;) {
    last = stop_.load(std::memory_order_relaxed);
    for (const auto& track : tracks_) process(*track, last);
    if (!last) std::this_thread::sleep_for(kFlightPollInterval);
  }
  for (const auto& track : tracks_) {
    if (track->queue) track->status->flight_tap.detach();
  }
}

// A failure concerns this sensor only, and the next round tries again.
void FlightRecorder::process(Track& track, bool last) {
  try {
    follow_device(track);
    write_if_due(track, Clock::now(), last);
    track.failure_logged = false;
  } catch (const std::exception& error) {
    failures_.fetch_add(1, std::memory_order_relaxed);
    if (!track.failure_logged)
      write_log(LogLevel::error, {track.status->name, Cause::machine},
                track.status->name + ": its last seconds are not kept: " + error.what());
    track.failure_logged = true;
  }
}

// Allocates when the device is known, and again when it has another layout.
void FlightRecorder::follow_device(Track& track) {
  const DeviceFacts facts = track.status->facts();
  if (!facts.layout || (track.layout && *track.layout == *facts.layout)) return;
  const std::size_t taxels = facts.layout->size();
  const double rate_hz = facts.rate_hz > 0 ? facts.rate_hz : kUnknownRateHz;
  const std::size_t wanted = frames_in(2 * settings_.seconds, rate_hz);
  const auto frame_bytes = static_cast<double>(FrameHistory::bytes_of_frame(taxels));
  const auto room =
      static_cast<std::size_t>(settings_.max_mb * 1e6 / static_cast<double>(tracks_.size()) / frame_bytes);
  const std::size_t queue = std::min(frames_in(kQueueSeconds, rate_hz), std::max<std::size_t>(room / 4, 1));
  const std::size_t frames = std::clamp<std::size_t>(room - std::min(room, queue), 1, wanted);
  if (frames < wanted) {
    write_log(LogLevel::warning, {track.status->name, Cause::configuration},
              fmt::format("{}: recorder.max_mb has room for {:.1f} s around an alert, not for {:.1f} s",
                          track.status->name, static_cast<double>(frames) / rate_hz, 2 * settings_.seconds));
  }
  auto history = std::make_unique<FrameHistory>(taxels, frames);
  auto frame_queue = std::make_unique<FrameQueue>(taxels, queue);
  if (track.queue) track.status->flight_tap.detach();
  track.history = std::move(history);
  track.queue = std::move(frame_queue);
  track.layout = facts.layout;
  track.status->flight_tap.attach(*track.queue);
}

// A frame is queued before its estimate. So all frames of the estimates counted here are in the frame queue.
void FlightRecorder::drain_queues(Track& track) {
  const std::size_t estimates = track.estimates_in.read_available();
  while (const FrameSlot* frame = track.queue->front()) {
    track.history->push(*frame);
    track.queue->pop();
  }
  TimedEstimate timed;
  for (std::size_t i = 0; i < estimates && track.estimates_in.pop(timed); ++i)
    track.history->attach_estimate(timed.time_ns, timed.estimate);
}

void FlightRecorder::write_if_due(Track& track, Clock::time_point now, bool last) {
  if (!track.queue) return;
  drain_queues(track);
  const Reason wanted = track.trigger_reason.exchange(Reason::none, std::memory_order_relaxed);
  if (wanted > track.reason) {
    track.reason = wanted;
    track.pending.store(true, std::memory_order_relaxed);
    track.due =
        now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(settings_.seconds));
  }
  if (track.reason != Reason::none && (now >= track.due || last)) write(track, last);
}

void FlightRecorder::write(Track& track, bool last) {
  const Reason reason = std::exchange(track.reason, Reason::none);
  track.pending.store(false, std::memory_order_relaxed);
  track.begun.fetch_add(1, std::memory_order_relaxed);
  const std::string name = recording_name(track.status->name);
  const char* const kind = reason == Reason::slip ? "slip" : "request";
  const auto path = folder_.path() / RecordingsFolder::file_name(name, kind);
  const FrameHistory& history = *track.history;
  if (history.size() == 0) return finish(track, {}, "no frame has come");
  const DeviceFacts facts = track.status->facts();
  const Now now = Now::read();
  bool zeroed = true;
  for (std::size_t i = 0; i < history.size(); ++i) zeroed = zeroed && history[i].zeroed;
  const RecordingHeader header{.sensor = track.status->name,
                               .sensor_class = facts.sensor_class,
                               .layout = *track.layout,
                               .rate_hz = facts.rate_hz,
                               .simulated = track.status->simulated.load(std::memory_order_relaxed),
                               .start_realtime_ns = now.realtime_of(history[0].time_ns),
                               .start_monotonic_ns = history[0].time_ns,
                               .description = facts.description,
                               .zeroed = zeroed};
  // At a stop what a client requested is broken off; a slip's recording is evidence, and has all the time
  // that Engine::stop leaves it.
  const auto give_up =
      last && reason == Reason::request ? Clock::now() + kStopPatience : Clock::time_point::max();
  const std::error_code error = folder_.add(name, kind, [&](int fd) {
    RecordingWriter writer(fd, header);
    std::error_code trouble;
    for (std::size_t i = 0; i < history.size() && !trouble; ++i) {
      trouble = Clock::now() < give_up ? writer.append(history[i], history.estimate(i))
                                       : std::make_error_code(std::errc::operation_canceled);
    }
    return trouble ? trouble : writer.finish();
  });
  if (error) {
    const std::string trouble = path.string() + " could not be kept: " + error.message();
    write_log(LogLevel::error, {track.status->name, Cause::machine}, track.status->name + ": " + trouble);
    finish(track, {}, trouble);
    failures_.fetch_add(1, std::memory_order_release);  // after the outcome: who sees the count finds it
    return;
  }
  finish(track, path.string(), {});
  files_written_.fetch_add(1, std::memory_order_release);  // likewise
  write_log(
      LogLevel::info, {track.status->name},
      track.status->name + ": " + std::to_string(history.size()) + " frames are kept in " + path.string());
}

}  // namespace slipd
