#include "daemon/record/flight_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <thread>

#include "core/storage/recording.hpp"
#include "daemon/log/log.hpp"
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

std::size_t frames_in(double seconds, double rate_hz) {
  return static_cast<std::size_t>(std::ceil(seconds * rate_hz)) + 16;
}

// "left-20261120T235959.123Z-slip.rec"
std::string file_name(const std::string& sensor, const char* reason) {
  const std::int64_t ms = Now::read().realtime_ns / 1'000'000;
  const auto seconds = static_cast<std::time_t>(ms / 1000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 64> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%S", &utc);
  std::string fraction = std::to_string(1000 + ms % 1000);
  fraction[0] = '.';
  return sensor + "-" + std::string(text.data(), length) + fraction + "Z-" + reason + ".rec";
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
  stop_.store(true, std::memory_order_relaxed);
}

void FlightRecorder::start() {
  thread_ = Thread("flight", kFlightStackBytes, [this] { run(); });
}

void FlightRecorder::trigger(std::size_t sensor, const char* reason) noexcept {
  tracks_[sensor]->trigger_reason.store(reason, std::memory_order_relaxed);
}

void FlightRecorder::add_estimate(std::size_t sensor, const Estimate& estimate) noexcept {
  tracks_[sensor]->estimates_in.push({.time_ns = estimate.time_ns,
                                      .estimate = {.state = static_cast<std::uint8_t>(estimate.state),
                                                   .alert = static_cast<std::uint8_t>(estimate.alert),
                                                   .gamma = estimate.gamma.value_or(kUnknown),
                                                   .sigma = estimate.sigma.value_or(kUnknown),
                                                   .friction = estimate.friction.value_or(kUnknown),
                                                   .normal_n = estimate.normal_n.value_or(kUnknown),
                                                   .shear_n = estimate.shear_n.value_or(kUnknown)}});
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
  if (const char* trigger_reason = track.trigger_reason.exchange(nullptr, std::memory_order_relaxed);
      trigger_reason != nullptr && track.reason == nullptr) {
    track.reason = trigger_reason;
    track.due =
        now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(settings_.seconds));
  }
  if (track.reason != nullptr && (now >= track.due || last)) write(track);
}

void FlightRecorder::write(Track& track) {
  const std::string name = file_name(track.status->name, track.reason);
  track.reason = nullptr;
  const FrameHistory& history = *track.history;
  if (history.size() == 0) return;
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
  const std::error_code error = folder_.add(name, [&](int fd) {
    RecordingWriter writer(fd, header);
    std::error_code trouble;
    for (std::size_t i = 0; i < history.size() && !trouble; ++i)
      trouble = writer.append(history[i], history.estimate(i));
    return trouble ? trouble : writer.flush();
  });
  if (error) {
    failures_.fetch_add(1, std::memory_order_relaxed);
    write_log(LogLevel::error, {track.status->name, Cause::machine},
              track.status->name + ": " + (folder_.path() / name).string() +
                  " could not be kept: " + error.message());
    return;
  }
  files_written_.fetch_add(1, std::memory_order_relaxed);
  write_log(LogLevel::info, {track.status->name},
            track.status->name + ": " + std::to_string(history.size()) + " frames are kept in " +
                (folder_.path() / name).string());
}

}  // namespace slipd
