// Force sensors that are polled over Modbus, TCP or RTU: each scan is one or more reads of registers, at the
// profile's rate by absolute time. libmodbus implements the protocol; it allocates nothing once connected.
//
// Several reads make one scan only if all were answered within its time-out. No supported device numbers its
// scans, so reads of two scans cannot be distinguished in another way.
#pragma once

#include <memory>
#include <span>
#include <string>
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
  std::string why_no_frames() const override { return sensors_.why_no_frames("answers"); }

 private:
  struct Closes {
    void operator()(_modbus* context) const noexcept;
  };
  using Context = std::unique_ptr<_modbus, Closes>;
  enum class RequestResult : std::uint8_t { answered, late, refused, malformed, gone };

  // Where the device is: a host, or a serial line.
  struct Endpoint {
    std::string host;         // of TCP; empty: RTU
    int port = 0;             // of TCP
    std::string serial_line;  // of RTU, a device file; empty: TCP
    int baud = 0;             // of RTU, bit/s
    int unit = 0;             // the slave's address
    std::string text;         // for people
  };

  static Endpoint endpoint_of(const SensorSetup& sensor, const decode::ModbusMap& map);
  // Throws DriverError if the device answers a read of the scan with an exception.
  void refuse_what_is_refused();
  RequestResult request(std::size_t rule, std::chrono::microseconds patience) noexcept;

  decode::Profile profile_;
  Endpoint endpoint_;
  decode::Sensors sensors_;
  std::vector<std::uint8_t> answer_;
  Context context_;
  std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;  // of the next scan
  std::size_t next_ = 0;     // index of the read that continues the scan
  int unanswered_ = 0;       // consecutive requests without an answer
  int error_ = 0;            // libmodbus' of the last such request
};

}  // namespace slipd::modbus
