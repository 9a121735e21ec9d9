// Force sensors that are asked over Modbus, TCP or RTU: each scan is one read or more of registers, at the
// profile's rate by absolute time. libmodbus does the talking; it allocates nothing once connected.
//
// Several reads make one scan only if they were answered within its time-out; a device that numbers its scans
// could be checked better, but none of ours does.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/decode/sensors.hpp"

struct _modbus;  // libmodbus' own name

namespace slipd::modbus {

class ModbusDriver final : public DeviceDriver {
 public:
  // Throws DriverError for a profile, device or options that cannot work.
  explicit ModbusDriver(const std::vector<SensorSetup>& sensors);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override;

 private:
  struct Closes {
    void operator()(_modbus* context) const noexcept;
  };
  using Context = std::unique_ptr<_modbus, Closes>;
  enum class Asked : std::uint8_t { answered, late, refused, gone };

  // Where the device is: a host, or a serial line.
  struct Place {
    std::string host;  // of TCP; empty: RTU
    int port = 0;
    std::string serial_line;
    int baud = 0;
    int unit = 0;
    std::string text;  // for people
  };

  static Place place_of(const SensorSetup& sensor, const decode::ModbusMap& map);
  Asked ask(std::size_t rule, std::chrono::microseconds patience) noexcept;

  decode::Profile profile_;
  Place place_;
  decode::Sensors sensors_;
  std::vector<std::uint8_t> answer_;
  Context context_;
  std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;  // of the next scan
  std::size_t next_ = 0;     // read that continues the scan
  int unanswered_ = 0;       // in a row
};

}  // namespace slipd::modbus
