// Tactile sensors that are HID devices, by hidapi's hidraw backend: reports by themselves, one scan in one or
// several of them. The kernel keeps 64 reports for a reader that is late; more are lost, and the decoder
// drops the scan that they belong to. hidapi gives no time of arrival: it is taken when a report is read.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/decode/sensors.hpp"

struct hid_device_;  // hidapi's own name

namespace slipd::hid {

class HidDriver final : public DeviceDriver {
 public:
  // Throws DriverError for a profile, device or options that cannot work.
  explicit HidDriver(const std::vector<SensorSetup>& sensors);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override;

 private:
  struct Closes {
    void operator()(hid_device_* device) const noexcept;
  };

  void find_places(const std::string& path);
  bool say(const std::vector<decode::Message>& messages) noexcept;
  ReadResult take(std::span<const std::uint8_t> report, std::int64_t time_ns,
                  std::span<FrameSlot> slots) noexcept;

  decode::Profile profile_;
  std::string serial_, path_;  // which device; empty: the only one there is
  std::vector<SensorSetup> setups_;
  decode::Sensors sensors_;
  bool by_usage_ = false;  // the device says where its values stand
  bool numbered_ = false;  // reports begin with their id
  std::unique_ptr<hid_device_, Closes> device_;
};

}  // namespace slipd::hid
