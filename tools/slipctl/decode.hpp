// slipctl decode: what a capture of a device's bytes means by a profile. Asks no daemon.
#pragma once

#include <iosfwd>
#include <string>

namespace slipctl {

struct DecodeOptions {
  std::string profile;
  unsigned board = 1;  // of a CAN bus
  bool json = false;
};

// The capture is, by the profile's driver: can: lines as `candump -L` writes them; usb: what bulk transfers
// brought; hid: reports as /dev/hidraw* gives them; modbus: the registers' bytes, read after read. A line for
// each frame on `out`; what was dropped at the end on `remarks`. False: there was no frame.
// Throws slipd::DriverError for a profile that is not there or cannot work.
bool decode(const DecodeOptions& options, std::istream& in, std::ostream& out, std::ostream& remarks);

}  // namespace slipctl
