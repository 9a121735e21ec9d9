// Tactile sensors that are HID devices, read with hidapi's hidraw backend. The device sends input reports
// unasked; one scan is one report or several. The kernel buffers 64 reports; when more wait, reports are lost
// and the decoder drops their scans. hidapi gives no time of arrival: a report's time is that of its reading.
#pragma once

#include <memory>
#include <span>
#include <string>
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
  std::string why_no_frames() const override { return sensors_.why_no_frames("reports"); }

 private:
  struct Closes {
    void operator()(hid_device_* device) const noexcept;
  };

  void resolve_places(const std::string& path);
  bool send(const std::vector<decode::Message>& messages) noexcept;
  ReadResult take(std::span<const std::uint8_t> report, std::int64_t time_ns,
                  std::span<FrameSlot> slots) noexcept;

  decode::Profile profile_;
  std::string serial_, path_;  // select the device; empty: the only one present
  std::vector<SensorSetup> setups_;
  decode::Sensors sensors_;
  bool by_usage_ = false;        // the device's descriptor gives the places of its values
  bool has_report_ids_ = false;  // reports begin with their id
  std::unique_ptr<hid_device_, Closes> device_;
};

}  // namespace slipd::hid
