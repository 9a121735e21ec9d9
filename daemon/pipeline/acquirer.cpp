#include "daemon/pipeline/acquirer.hpp"

#include <algorithm>
#include <new>

#include "core/bias/gain.hpp"

namespace slipd {
namespace {

using Clock = Doorbell::Clock;
using namespace std::chrono_literals;

constexpr auto kReadTimeout = 50ms;  // how long a stop may have to wait for a driver that behaves
constexpr auto kFirstBackOff = 100ms;
constexpr auto kLongestBackOff = 5000ms;
constexpr std::size_t kAcquirerStackBytes = std::size_t{512} * 1024;

// One for each taxel; none where all are 1.
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
                   std::vector<std::unique_ptr<SensorRuntime>>& runtimes, BiasStore& zeros, LogRing& log,
                   Doorbell& estimate, FeedOpened opened)
    : driver_(std::move(driver)), zeros_(zeros), log_(log), estimate_(estimate), opened_(std::move(opened)) {
  for (const std::size_t sensor : sensors) {
    SensorChannel& channel = channels_.emplace_back();
    channel.sensor = sensor;
    channel.runtime = runtimes[sensor].get();
    name_ += (name_.empty() ? "" : ", ") + channel.runtime->status.name;
  }
  slots_.resize(channels_.size());
}

void Acquirer::start(const RealtimeSettings& settings, const RealtimeGrant& grant) {
  realtime_ = settings;
  grant_ = grant;
  thread_ = Thread("acq:" + name_, kAcquirerStackBytes, [this] { run(); });
}

void Acquirer::ask_to_stop() noexcept {
  stop_.store(true, std::memory_order_relaxed);
  stop_bell_.ring();
}

void Acquirer::run() {
  for (;;) {
    const std::uint32_t rung = stop_bell_.rung();  // first: a stop after the look at it ends the wait
    if (stopping()) return;
    try {
      return attend();
    } catch (const std::bad_alloc&) {  // in what is done while setting up: once more, then
      driver_->close();
      set_link(Link::absent);
      stop_bell_.wait(rung, Clock::now() + kLongestBackOff);
    }
  }
}

void Acquirer::attend() {
  auto back_off = Clock::duration(kFirstBackOff);
  for (;;) {
    const std::uint32_t rung = stop_bell_.rung();
    if (stopping()) return;
    if (!open()) {
      set_link(Link::absent);
      stop_bell_.wait(rung, Clock::now() + back_off);
      back_off = std::min<Clock::duration>(2 * back_off, kLongestBackOff);
      continue;
    }
    delivered_ = false;
    set_link(Link::open);
    enter_realtime(realtime_, grant_);
    const Ending ending = pump();
    leave_realtime(grant_);
    driver_->close();
    for (auto& channel : channels_) {
      if (channel.zero) channel.zero->rest();
    }
    if (ending == Ending::ended) {
      log_.write(LogLevel::info, {name_}, "%s: the recording has ended", name_.c_str());
      set_link(Link::ended);
      break;
    }
    if (ending == Ending::disconnected) {
      log_.write(LogLevel::warning, {name_, Cause::device},
                 "%s: the device is gone; it will be reopened when it is back", name_.c_str());
      for (auto& channel : channels_)
        channel.runtime->status.change_facts([](DeviceFacts& f) { f.trouble = "the device is gone"; });
      set_link(Link::absent);
      // A device that opens but says nothing is no better than one that does not open.
      back_off = delivered_ ? Clock::duration(kFirstBackOff)
                            : std::min<Clock::duration>(2 * back_off, kLongestBackOff);
      stop_bell_.wait(rung, Clock::now() + back_off);
    }
  }
}

bool Acquirer::open() {
  std::string trouble;
  try {
    const DeviceInfo info = driver_->open();
    if (info.sensors.size() == channels_.size()) {
      wire(info);
      log_.write(LogLevel::info, {name_}, "%s: open: %s", name_.c_str(), info.description.c_str());
      last_trouble_.clear();
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
  if (trouble != last_trouble_) {
    log_.write(LogLevel::error, {name_, Cause::device}, "%s: %s (tried again until it works)", name_.c_str(),
               trouble.c_str());
    last_trouble_ = trouble;
    for (auto& channel : channels_)
      channel.runtime->status.change_facts([&](DeviceFacts& f) { f.trouble = trouble; });
  }
  return false;
}

void Acquirer::wire(const DeviceInfo& info) {
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
                      channel.feed->info.sensor_class == sensor.sensor_class && channel.feed->paced == paced;
    if (!same) {
      channel.feed = std::make_shared<FrameFeed>(sensor, paced);
      opened_(channel.sensor, channel.feed);
    }
    slots_[i] = channel.feed->mailbox.writable();
    wire_zero(channel, info, sensor);
  }
  was_open_ = true;
}

// The same device goes on with the zero that it had; another one has its own.
void Acquirer::wire_zero(SensorChannel& channel, const DeviceInfo& info, const SensorInfo& sensor) {
  SensorStatus& status = channel.runtime->status;
  const SensorSetup& setup = channel.runtime->settings.setup;
  status.zero.needed.store(!sensor.zeroed, std::memory_order_relaxed);
  const BiasIdentity identity{.driver = status.driver,
                              .profile = setup.profile,
                              .device = info.serial.empty() ? setup.device.dump() : "serial " + info.serial,
                              .part = sensor.part.empty() ? status.name : sensor.part,
                              .taxels = sensor.layout.size()};
  if (!sensor.zeroed && channel.zero && channel.zero->identity() == identity) return channel.zero->reopened();
  if (channel.zero) zeros_.leave(channel.zero);
  channel.zero = sensor.zeroed ? nullptr : zeros_.attend(status, sensor, identity, log_);
}

void Acquirer::set_link(Link link) noexcept {
  // Release: whoever reads it also finds the frames that came before.
  for (auto& channel : channels_) channel.runtime->status.link.store(link, std::memory_order_release);
  estimate_.ring();
}

Acquirer::Ending Acquirer::pump() noexcept {
  while (!stopping()) {
    const ReadResult result = driver_->read(slots_, kReadTimeout);
    // A driver that names a sensor it does not have is at fault; what it read is of no use.
    const bool known = result.sensor < channels_.size();
    SensorStatus& status = channels_[known ? result.sensor : 0].runtime->status;
    switch (known || result.status != ReadStatus::frame ? result.status : ReadStatus::corrupt) {
      case ReadStatus::frame:
        if (!deliver(result.sensor)) return Ending::stopped;
        break;
      case ReadStatus::timeout:
        status.timeouts.fetch_add(1, std::memory_order_relaxed);
        break;
      case ReadStatus::corrupt:
        status.corrupt.fetch_add(1, std::memory_order_relaxed);
        break;
      case ReadStatus::disconnected:
        return Ending::disconnected;
      case ReadStatus::end:
        return Ending::ended;
    }
  }
  return Ending::stopped;
}

// False: told to stop while waiting for the frame before to be taken.
bool Acquirer::deliver(std::size_t index) noexcept {
  SensorChannel& channel = channels_[index];
  FrameSlot& slot = slots_[index];
  FrameFeed& feed = *channel.feed;
  while (feed.paced && feed.mailbox.unread()) {
    if (stopping()) return false;
    const std::uint32_t rung = feed.taken.rung();
    if (feed.mailbox.unread()) feed.taken.wait(rung, Clock::now() + kReadTimeout);
  }
  ++channel.tally.received;
  delivered_ = true;
  if (channel.last_sequence && slot.sequence > *channel.last_sequence + 1) {
    ++channel.tally.gaps;
    channel.tally.lost += slot.sequence - *channel.last_sequence - 1;
  }
  channel.last_sequence = slot.sequence;
  slot.zeroed = true;
  if (channel.zero) channel.zero->apply(slot);
  if (!channel.gain.empty()) apply_gain(channel.gain, slot);
  channel.runtime->status.tap.offer(slot);
  channel.runtime->status.flight_tap.offer(slot);
  feed.mailbox.publish(slot, channel.tally);
  slot = feed.mailbox.writable();
  estimate_.ring();
  if (channel.zero) channel.zero->afterwards();
  return true;
}

}  // namespace slipd
