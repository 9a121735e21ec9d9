#include "daemon/pipeline/acquirer.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "core/zero/gain.hpp"

namespace slipd {
namespace {

using Clock = Doorbell::Clock;
using namespace std::chrono_literals;

// Time-out of one read: the longest that a stop waits for a driver that keeps it.
constexpr auto kReadTimeout = 50ms;
// Pause before a device that failed is opened again, doubled at each failure up to the second. Longer: a
// device that is plugged in again is found later. Shorter: more load and more log while it is away.
constexpr auto kFirstBackOff = 100ms;
constexpr auto kLongestBackOff = 5000ms;
constexpr auto kSilence = 2s;  // without a frame since the device was opened, before the reason is asked for
// A call of the driver that lasts longer than it may by this much hangs. Shorter: a busy machine looks like a
// driver that hangs. Longer: the reason comes later.
constexpr auto kHang = 2s;
constexpr auto kOpening = 5s;  // that open may last
// Between two times that are left in DriverWatch while reads return. Shorter: more writes for each read, to
// what other threads look at, for all sensors of a bus. Longer: a hanging read is noticed that much earlier.
constexpr auto kWatchInterval = 100ms;
// Frames over which the time between two is averaged: more than one scan of the largest bus has. Fewer: the
// pause after a scan counts for the frames of the next. More: a change of the rate is seen later.
constexpr std::int64_t kFramesOfInterval = 256;
// A longer pause between frames says nothing more of the rate, ns.
constexpr std::int64_t kLongestInterval = 100'000'000;
constexpr std::size_t kAcquirerStackBytes = std::size_t{512} * 1024;

// One factor a taxel; empty if all are 1. Throws DriverError if their number does not fit.
std::vector<float> gain_of(const SensorSettings& sensor, std::size_t taxels) {
  const auto& gain = sensor.gain;
  if (std::all_of(gain.begin(), gain.end(), [](float each) { return each == 1; })) return {};
  if (gain.size() == taxels) return gain;
  if (gain.size() == 1) return std::vector<float>(taxels, gain.front());
  throw DriverError(sensor.setup.name + " has " + std::to_string(gain.size()) +
                    " values of \"gain\", but its device " + std::to_string(taxels) +
                    " taxels: give it one for each, or one number");
}

}  // namespace

Acquirer::Acquirer(std::unique_ptr<DeviceDriver> driver, const std::vector<std::size_t>& sensors,
                   std::vector<std::unique_ptr<SensorRuntime>>& runtimes, BiasStore& bias_store, LogRing& log,
                   EstimateThreads& estimate, FeedOpened opened)
    : driver_(std::move(driver)), bias_store_(bias_store), log_(log), opened_(std::move(opened)) {
  for (const std::size_t sensor : sensors) {
    SensorChannel& channel = channels_.emplace_back();
    channel.sensor = sensor;
    channel.runtime = runtimes[sensor].get();
    channel.estimate = &estimate.of(sensor);
    name_ += (name_.empty() ? "" : ", ") + channel.runtime->status.name;
  }
  slots_.resize(channels_.size());
}

void Acquirer::start(const RealtimeSettings& settings, const RealtimeGrant& grant) {
  realtime_ = settings;
  grant_ = grant;
  thread_ = Thread("acq:" + name_, kAcquirerStackBytes, [this] { run(); });
}

void Acquirer::request_stop() noexcept {
  stop_.store(true, std::memory_order_relaxed);
  stop_bell_.ring();
}

void Acquirer::run() {
  for (;;) {
    const std::uint32_t rung = stop_bell_.ring_count();  // before stopping(): a later stop ends the wait
    if (stopping()) return;
    try {
      return open_and_read();
    } catch (const std::bad_alloc&) {  // while setting up: try again later
      driver_->close();
      set_link(DeviceLink::absent);
      stop_bell_.wait(rung, Clock::now() + kLongestBackOff);
    }
  }
}

void Acquirer::open_and_read() {
  auto back_off = Clock::duration(kFirstBackOff);
  for (;;) {
    const std::uint32_t rung = stop_bell_.ring_count();
    if (stopping()) return;
    if (!open()) {
      set_link(DeviceLink::absent);
      stop_bell_.wait(rung, Clock::now() + back_off);
      back_off = std::min<Clock::duration>(2 * back_off, kLongestBackOff);
      continue;
    }
    delivered_ = silent_ = away_ = false;
    opened_at_ = Clock::now();
    set_link(DeviceLink::open);
    const ReadEnd end = read_in_realtime();
    driver_->close();
    for (auto& channel : channels_) {
      if (channel.bias) channel.bias->flush_to_store(end == ReadEnd::stopped);
    }
    if (end == ReadEnd::ended) {
      log_.write(LogLevel::info, {name_}, "%s: the recording has ended", name_.c_str());
      set_link(DeviceLink::ended);
      break;
    }
    if (end == ReadEnd::changed) stop_bell_.wait(rung, Clock::now() + kFirstBackOff);
    if (end == ReadEnd::disconnected) {
      log_.write(LogLevel::warning, {name_, Cause::device},
                 "%s: the device is gone; it will be reopened when it is back", name_.c_str());
      for (auto& channel : channels_)
        channel.runtime->status.change_facts([](DeviceFacts& f) { f.trouble = "the device is gone"; });
      set_link(DeviceLink::absent);
      // A device that opens but delivers nothing is treated like one that does not open.
      back_off = delivered_ ? Clock::duration(kFirstBackOff)
                            : std::min<Clock::duration>(2 * back_off, kLongestBackOff);
      stop_bell_.wait(rung, Clock::now() + back_off);
    }
  }
}

bool Acquirer::open() {
  std::string trouble;
  try {
    const DeviceInfo info = open_driver();
    if (info.sensors.size() == channels_.size()) {
      connect_sensors(info);
      log_.write(LogLevel::info, {name_}, "%s: open: %s", name_.c_str(), info.description.c_str());
      last_logged_trouble_.clear();
      return true;
    }
    trouble = "the driver speaks of " + std::to_string(info.sensors.size()) + " sensors where " +
              std::to_string(channels_.size()) + " are configured";
  } catch (const std::exception& error) {
    trouble = error.what();
  } catch (...) {
    trouble = "the driver threw something that is no std::exception";
  }
  driver_->close();
  if (trouble != last_logged_trouble_) {
    log_.write(LogLevel::error, {name_, Cause::device}, "%s: %s (tried again until it works)", name_.c_str(),
               trouble.c_str());
    last_logged_trouble_ = trouble;
    for (auto& channel : channels_)
      channel.runtime->status.change_facts([&](DeviceFacts& f) { f.trouble = trouble; });
  }
  return false;
}

DeviceInfo Acquirer::open_driver() {
  enter_driver(DriverWatch::Call::open, kOpening);
  try {
    DeviceInfo info = driver_->open();
    leave_driver();
    return info;
  } catch (...) {
    leave_driver();
    throw;
  }
}

void Acquirer::enter_driver(DriverWatch::Call call, Clock::duration allowed) noexcept {
  const auto now = Clock::now();
  if (entered_at_ && now - *entered_at_ < kWatchInterval) return;
  entered_at_ = now;
  const std::int64_t due_ns = (now + allowed + kHang).time_since_epoch() / std::chrono::nanoseconds(1);
  for (auto& channel : channels_) channel.runtime->status.driver_watch.enter(call, due_ns);
}

void Acquirer::leave_driver() noexcept {
  entered_at_.reset();
  for (auto& channel : channels_) channel.runtime->status.driver_watch.leave();
}

void Acquirer::connect_sensors(const DeviceInfo& info) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    SensorChannel& channel = channels_[i];
    const SensorInfo& sensor = info.sensors[i];
    SensorStatus& status = channel.runtime->status;
    status.change_facts([&](DeviceFacts& facts) {
      facts.description = info.description;
      facts.serial = info.serial;
      facts.sensor_class = sensor.sensor_class;
      facts.layout = sensor.layout;
      facts.rate_hz = sensor.rate_hz;
      facts.trouble.clear();
    });
    status.simulated.store(info.simulated, std::memory_order_relaxed);
    channel.last_sequence.reset();
    channel.gain = gain_of(channel.runtime->settings, sensor.layout.size());
    if (was_open_) status.reconnects.fetch_add(1, std::memory_order_relaxed);
    const bool paced = driver_->paced_by_consumer();
    const bool same = channel.feed && channel.feed->info.layout == sensor.layout &&
                      channel.feed->info.sensor_class == sensor.sensor_class &&
                      channel.feed->info.calibrated == sensor.calibrated && channel.feed->paced == paced;
    if (!same) {
      channel.feed = std::make_shared<FrameFeed>(sensor, paced);
      opened_(channel.sensor, channel.feed);
    }
    slots_[i] = channel.feed->mailbox.writable();
    connect_bias(channel, info, sensor);
  }
  was_open_ = true;
}

// The same device continues with its bias. Another device gets its own from the store.
void Acquirer::connect_bias(SensorChannel& channel, const DeviceInfo& info, const SensorInfo& sensor) {
  SensorStatus& status = channel.runtime->status;
  const SensorSetup& setup = channel.runtime->settings.setup;
  status.bias.needed.store(!sensor.zeroed || !sensor.calibrated, std::memory_order_relaxed);
  status.bias.possible.store(sensor.calibrated, std::memory_order_relaxed);
  const BiasIdentity identity{.driver = status.driver,
                              .profile = setup.profile,
                              .device = info.serial.empty() ? setup.device.dump() : "serial " + info.serial,
                              .part = sensor.part.empty() ? status.name : sensor.part,
                              .taxels = sensor.layout.size()};
  const bool measured = !sensor.zeroed && sensor.calibrated;
  if (measured && channel.bias && channel.bias->identity() == identity)
    return channel.bias->device_reopened();
  if (channel.bias) bias_store_.unregister_sensor(channel.bias);
  channel.bias = measured ? bias_store_.register_sensor(status, sensor, identity, log_) : nullptr;
  if (!channel.bias) status.change_facts([](DeviceFacts& facts) { facts.zero_trouble.clear(); });
  if (!sensor.calibrated) status.bias.report.store(BiasReport{});
}

void Acquirer::set_link(DeviceLink link) noexcept {
  // Release: pairs with the acquire in EstimateLoop::process and can::CanSource::view_at, so that they see
  // the frames delivered before.
  for (auto& channel : channels_) {
    channel.runtime->status.link.store(link, std::memory_order_release);
    channel.estimate->ring();
  }
}

// Reads until the device is closed. Leaves real time for a moment to tell that no frame comes, and why, and
// that one has come.
Acquirer::ReadEnd Acquirer::read_in_realtime() {
  for (;;) {
    enter_realtime(realtime_, grant_);
    const ReadEnd end = read_until_closed();
    leave_driver();
    leave_realtime(grant_);
    if (end != ReadEnd::silent && end != ReadEnd::away && end != ReadEnd::speaking) return end;
    set_silence(end);
  }
}

void Acquirer::set_silence(ReadEnd how) {
  silent_ = how != ReadEnd::speaking;
  away_ = how == ReadEnd::away;
  std::string why;
  if (silent_) {
    why = driver_->why_no_frames();
    if (why.empty()) why = "it is open, but sends nothing: is it on, and is its bus set up as it needs?";
    log_.write(LogLevel::warning, {name_, Cause::device}, "%s: no frame: %s", name_.c_str(), why.c_str());
  } else {
    log_.write(LogLevel::info, {name_}, "%s: frames arrive", name_.c_str());
  }
  for (auto& channel : channels_) {
    // What the sensor carries when somebody sends frames again is not known.
    if (away_ && channel.bias) channel.bias->device_reopened();
    channel.runtime->status.change_facts([&](DeviceFacts& facts) {
      // An estimator that could not be made is not forgotten.
      if (facts.trouble.empty() || facts.trouble == silence_) facts.trouble = why;
    });
  }
  silence_ = why;
  if (away_) set_link(DeviceLink::absent);
}

Acquirer::ReadEnd Acquirer::read_until_closed() noexcept {
  while (!stopping()) {
    enter_driver(DriverWatch::Call::read, kReadTimeout);
    const ReadResult result = driver_->read(slots_, kReadTimeout);
    // A frame for a sensor that the device does not have counts as corrupt.
    const bool known = result.sensor < channels_.size();
    SensorStatus& status = channels_[known ? result.sensor : 0].runtime->status;
    switch (known || result.status != ReadStatus::frame ? result.status : ReadStatus::corrupt) {
      case ReadStatus::frame:
        if (away_) come_back();
        if (!deliver(result.sensor)) return ReadEnd::stopped;
        if (silent_) return ReadEnd::speaking;
        break;
      case ReadStatus::timeout:
        status.timeouts.fetch_add(1, std::memory_order_relaxed);
        break;
      case ReadStatus::corrupt:
        status.corrupt.fetch_add(1, std::memory_order_relaxed);
        break;
      case ReadStatus::away:
        status.timeouts.fetch_add(1, std::memory_order_relaxed);
        if (!away_) return ReadEnd::away;
        break;
      case ReadStatus::disconnected:
        return ReadEnd::disconnected;
      case ReadStatus::changed:
        return ReadEnd::changed;
      case ReadStatus::end:
        return ReadEnd::ended;
    }
    if (!delivered_ && !silent_ && Clock::now() - opened_at_ > kSilence) return ReadEnd::silent;
  }
  return ReadEnd::stopped;
}

// Before the first frame after `away` is published, so that it is not taken for one of an absent device.
void Acquirer::come_back() noexcept {
  away_ = false;
  for (auto& channel : channels_) channel.runtime->status.reconnects.fetch_add(1, std::memory_order_relaxed);
  set_link(DeviceLink::open);
}

// Mean time between frames of the device so far, ns.
std::int64_t Acquirer::interval_since_last_frame() noexcept {
  const auto now = Clock::now();
  const std::int64_t since_ns = (now - std::exchange(last_frame_at_, now)) / std::chrono::nanoseconds(1);
  interval_ns_ += (std::min(since_ns, kLongestInterval) - interval_ns_) / kFramesOfInterval;
  return interval_ns_;
}

// False: a stop was requested while the source waited for the estimator.
bool Acquirer::deliver(std::size_t index) noexcept {
  SensorChannel& channel = channels_[index];
  FrameSlot& slot = slots_[index];
  FrameFeed& feed = *channel.feed;
  while (feed.paced && feed.mailbox.has_unread()) {
    if (stopping()) return false;
    leave_driver();  // the estimator may take long, as while a model is trained
    const std::uint32_t rung = feed.taken.ring_count();
    if (feed.mailbox.has_unread()) feed.taken.wait(rung, Clock::now() + kReadTimeout);
  }
  ++channel.arrivals.received;
  delivered_ = true;
  if (channel.last_sequence && slot.sequence > *channel.last_sequence + 1) {
    ++channel.arrivals.gaps;
    channel.arrivals.lost += slot.sequence - *channel.last_sequence - 1;
  }
  channel.last_sequence = slot.sequence;
  slot.zeroed = feed.info.calibrated;
  if (channel.bias) channel.bias->apply(slot);
  if (!channel.gain.empty()) apply_gain(channel.gain, slot);
  channel.runtime->status.record_tap.offer(slot);
  channel.runtime->status.flight_tap.offer(slot);
  feed.mailbox.publish(slot, channel.arrivals);
  slot = feed.mailbox.writable();
  if (channel.bias) channel.bias->after_publish();
  const std::int64_t interval_ns = interval_since_last_frame();
  if (feed.paced) {  // the device makes its next frame while this one is estimated
    channel.estimate->ring();
  } else {
    channel.estimate->frame_delivered(channel.sensor, interval_ns);
  }
  return true;
}

}  // namespace slipd
