// A device that sends a stream of bytes (USB bulk transfers, a serial line): bytes are cut into packets as
// the profile describes, packets make frames. What carries the bytes is a Transport.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/decode/framer.hpp"
#include "drivers/decode/sensors.hpp"

namespace slipd::decode {

// One transfer from the device.
struct ReceivedBytes {
  std::span<const std::uint8_t> bytes;  // valid until the next receive()
  std::int64_t time_ns = 0;             // CLOCK_MONOTONIC, when they had arrived
};

enum class ReceiveResult : std::uint8_t {
  bytes,           // a transfer has arrived
  timeout,         // none until give_up_ns
  transfer_error,  // a transfer failed and its bytes are lost; later ones can arrive
  disconnected     // the device is gone; only closing remains
};

class Transport {
 public:
  virtual ~Transport() = default;

  // Acquire thread.
  virtual ReceiveResult receive(ReceivedBytes& out, std::int64_t give_up_ns) noexcept = 0;

  // Acquire thread. Sends the profile's start messages again, without waiting for answers.
  virtual void restart() noexcept = 0;

  // Acquire thread. A packet is complete: a device that answers requests may get the next one.
  virtual void answered() noexcept {}

  // As DeviceDriver::why_no_frames. `garbage`: bytes so far that belonged to no packet.
  virtual std::string why_no_frames(std::uint64_t /*garbage*/) const { return {}; }
};

struct OpenedDevice {
  std::unique_ptr<Transport> transport;
  std::string place;   // the port, for people
  std::string serial;  // empty: it has none
};

class StreamDriver : public DeviceDriver {
 public:
  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override { transport_.reset(); }
  std::string why_no_frames() const override;

 protected:
  // Throws DriverError for sensors that the profile cannot have.
  StreamDriver(Profile profile, const std::vector<SensorSetup>& sensors);

  // Finds, opens and starts the device. Throws DriverError.
  virtual OpenedDevice open_device() = 0;
  const Profile& profile() const noexcept { return profile_; }

 private:
  ReadResult decode_held(std::span<FrameSlot> slots) noexcept;
  void restart_if_silent(std::int64_t now_ns) noexcept;

  const Profile profile_;
  Sensors sensors_;
  Framer framer_;
  std::unique_ptr<Transport> transport_;
  std::int64_t arrived_ns_ = 0;        // of the bytes that the framer got last
  std::int64_t last_activity_ns_ = 0;  // of the last transfer or of the last start messages
};

}  // namespace slipd::decode
