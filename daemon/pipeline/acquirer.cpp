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
constexpr std::size_t kStackBytes = std::size_t{512} * 1024;

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
                   std::vector<std::unique_ptr<Seat>>& seats, ZeroKeeper& zeros, LogRing& log,
                   Doorbell& estimate, FeedOpened opened)
    : driver_(std::move(driver)), zeros_(zeros), log_(log), estimate_(estimate), opened_(std::move(opened)) {
  for (const std::size_t sensor : sensors) {
    Outlet& outlet = outlets_.emplace_back();
    outlet.sensor = sensor;
    outlet.seat = seats[sensor].get();
    name_ += (name_.empty() ? "" : ", ") + outlet.seat->panel.name;
  }
  slots_.resize(outlets_.size());
}

void Acquirer::start(const RealtimeSettings& settings, const RealtimeGrant& grant) {
  realtime_ = settings;
  grant_ = grant;
  thread_ = Thread("acq:" + name_, kStackBytes, [this] { run(); });
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
    for (auto& outlet : outlets_) {
      if (outlet.zero) outlet.zero->rest();
    }
    if (ending == Ending::ended) {
      log_.write(LogLevel::info, {name_}, "%s: the recording has ended", name_.c_str());
      set_link(Link::ended);
      break;
    }
    if (ending == Ending::disconnected) {
      log_.write(LogLevel::warning, {name_, Cause::device},
                 "%s: the device is gone; it will be reopened when it is back", name_.c_str());
      for (auto& outlet : outlets_)
        outlet.seat->panel.change_facts([](DeviceFacts& f) { f.trouble = "the device is gone"; });
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
    if (info.sensors.size() == outlets_.size()) {
      wire(info);
      log_.write(LogLevel::info, {name_}, "%s: open: %s", name_.c_str(), info.description.c_str());
      last_trouble_.clear();
      return true;
    }
    trouble = "the driver speaks of " + std::to_string(info.sensors.size()) + " sensors where " +
              std::to_string(outlets_.size()) + " are configured";
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
    for (auto& outlet : outlets_)
      outlet.seat->panel.change_facts([&](DeviceFacts& f) { f.trouble = trouble; });
  }
  return false;
}

void Acquirer::wire(const DeviceInfo& info) {
  for (std::size_t i = 0; i < outlets_.size(); ++i) {
    Outlet& outlet = outlets_[i];
    const SensorInfo& sensor = info.sensors[i];
    Panel& panel = outlet.seat->panel;
    panel.change_facts([&](DeviceFacts& facts) {
      facts.description = info.description;
      facts.serial = info.serial;
      facts.sensor_class = sensor.sensor_class;
      facts.layout = sensor.layout;
      facts.rate_hz = sensor.rate_hz;
      facts.trouble.clear();
    });
    panel.simulated.store(info.simulated, std::memory_order_relaxed);
    outlet.last_sequence.reset();
    outlet.gain = gain_of(outlet.seat->settings, sensor.layout.size());
    if (was_open_) panel.reconnects.fetch_add(1, std::memory_order_relaxed);
    const bool paced = driver_->paced_by_consumer();
    const bool same = outlet.feed && outlet.feed->info.layout == sensor.layout &&
                      outlet.feed->info.sensor_class == sensor.sensor_class && outlet.feed->paced == paced;
    if (!same) {
      outlet.feed = std::make_shared<Feed>(sensor, paced);
      opened_(outlet.sensor, outlet.feed);
    }
    slots_[i] = outlet.feed->mailbox.writable();
    wire_zero(outlet, info, sensor);
  }
  was_open_ = true;
}

// The same device goes on with the zero that it had; another one has its own.
void Acquirer::wire_zero(Outlet& outlet, const DeviceInfo& info, const SensorInfo& sensor) {
  Panel& panel = outlet.seat->panel;
  const SensorSetup& setup = outlet.seat->settings.setup;
  panel.zero.needed.store(!sensor.zeroed, std::memory_order_relaxed);
  const ZeroIdentity identity{.driver = panel.driver,
                              .profile = setup.profile,
                              .device = info.serial.empty() ? setup.device.dump() : "serial " + info.serial,
                              .part = sensor.part.empty() ? panel.name : sensor.part,
                              .taxels = sensor.layout.size()};
  if (!sensor.zeroed && outlet.zero && outlet.zero->identity() == identity) return outlet.zero->reopened();
  if (outlet.zero) zeros_.leave(outlet.zero);
  outlet.zero = sensor.zeroed ? nullptr : zeros_.attend(panel, sensor, identity, log_);
}

void Acquirer::set_link(Link link) noexcept {
  // Release: whoever reads it also finds the frames that came before.
  for (auto& outlet : outlets_) outlet.seat->panel.link.store(link, std::memory_order_release);
  estimate_.ring();
}

Acquirer::Ending Acquirer::pump() noexcept {
  while (!stopping()) {
    const ReadResult result = driver_->read(slots_, kReadTimeout);
    // A driver that names a sensor it does not have is at fault; what it read is of no use.
    const bool known = result.sensor < outlets_.size();
    Panel& panel = outlets_[known ? result.sensor : 0].seat->panel;
    switch (known || result.status != ReadStatus::frame ? result.status : ReadStatus::corrupt) {
      case ReadStatus::frame:
        if (!deliver(result.sensor)) return Ending::stopped;
        break;
      case ReadStatus::timeout:
        panel.timeouts.fetch_add(1, std::memory_order_relaxed);
        break;
      case ReadStatus::corrupt:
        panel.corrupt.fetch_add(1, std::memory_order_relaxed);
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
  Outlet& outlet = outlets_[index];
  FrameSlot& slot = slots_[index];
  Feed& feed = *outlet.feed;
  while (feed.paced && feed.mailbox.unread()) {
    if (stopping()) return false;
    const std::uint32_t rung = feed.taken.rung();
    if (feed.mailbox.unread()) feed.taken.wait(rung, Clock::now() + kReadTimeout);
  }
  ++outlet.tally.received;
  delivered_ = true;
  if (outlet.last_sequence && slot.sequence > *outlet.last_sequence + 1) {
    ++outlet.tally.gaps;
    outlet.tally.lost += slot.sequence - *outlet.last_sequence - 1;
  }
  outlet.last_sequence = slot.sequence;
  slot.zeroed = true;
  if (outlet.zero) outlet.zero->apply(slot);
  if (!outlet.gain.empty()) apply_gain(outlet.gain, slot);
  outlet.seat->panel.tap.offer(slot);
  outlet.seat->panel.flight_tap.offer(slot);
  feed.mailbox.publish(slot, outlet.tally);
  slot = feed.mailbox.writable();
  estimate_.ring();
  if (outlet.zero) outlet.zero->afterwards();
  return true;
}

}  // namespace slipd
