// slipctl decode: decodes a capture of a device's bytes with a profile. Needs no daemon.
#pragma once

#include <iosfwd>
#include <string>

namespace slipctl {

struct DecodeOptions {
  std::string profile;  // its name
  unsigned board = 1;   // number of the board on a CAN bus
  bool json = false;    // print JSON
};

// The profile's driver determines the format of the capture. can: lines as `candump -L` writes them; usb: the
// bytes of bulk transfers; hid: reports as /dev/hidraw* returns them; modbus: the registers' bytes, read
// after read. Writes a line for each frame to `out` and a summary of dropped packets to `remarks`. False: no
// frame. Throws slipd::DriverError for a profile that does not exist or cannot work.
bool decode(const DecodeOptions& options, std::istream& in, std::ostream& out, std::ostream& remarks);

}  // namespace slipctl
