#include "drivers/decode/sensors.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace slipd::decode {

Sensors::Sensors(const Profile& profile, const std::vector<SensorSetup>& setups)
    : ready_(setups.size(), false) {
  std::vector<std::size_t> taken;
  for (const SensorSetup& setup : setups) {
    const auto number = setup.options.value("sensor", std::size_t{0});
    const std::string what = "sensor \"" + setup.name + "\": options: sensor " + std::to_string(number);
    if (number >= profile.sensors) {
      throw DriverError(what + " is not there; the device has " + std::to_string(profile.sensors) +
                        ", counted from 0");
    }
    if (std::ranges::find(taken, number) != taken.end()) throw DriverError(what + " is another's already");
    taken.push_back(number);
    decoders_.emplace_back(profile, number, 0);
    info_.push_back(info_of(profile, "sensor " + std::to_string(number)));
  }
}

ReadResult Sensors::take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns,
                         std::span<FrameSlot> slots) noexcept {
  ReadResult result;
  for (std::size_t i = 0; i < decoders_.size(); ++i) {
    const Outcome outcome = decoders_[i].take(id, bytes, time_ns, slots[i]);
    ready_[i] = outcome == Outcome::frame;
    if (outcome == Outcome::dropped) result = {ReadStatus::corrupt, static_cast<std::uint16_t>(i)};
  }
  return result.status == ReadStatus::corrupt ? result : next_ready();
}

ReadResult Sensors::next_ready() noexcept {
  for (std::size_t i = 0; i < ready_.size(); ++i) {
    if (!ready_[i]) continue;
    ready_[i] = false;
    return {ReadStatus::frame, static_cast<std::uint16_t>(i)};
  }
  return {ReadStatus::timeout, 0};
}

void Sensors::mark_packet_lost() noexcept {
  for (Decoder& decoder : decoders_) decoder.mark_packet_lost();
}

std::string Sensors::why_no_frames(const std::string& packets) const {
  for (const Decoder& decoder : decoders_) {
    std::string why = decoder.why_no_frames(packets);
    if (!why.empty()) return why;
  }
  return {};
}

void Sensors::reset() noexcept {
  for (Decoder& decoder : decoders_) decoder.reset();
  std::fill(ready_.begin(), ready_.end(), false);
}

}  // namespace slipd::decode
