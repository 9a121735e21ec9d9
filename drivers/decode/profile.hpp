// A device profile: the packets that a device sends, where its taxels are, how it is started.
// config/profile.schema.json describes the JSON keys; these structs hold a checked profile in SI units, in
// the form that the decoder needs. Set-up thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"
#include "wire/number.hpp"

namespace slipd::decode {

using wire::NumberKind;
using wire::NumberType;

enum class Channel : std::uint8_t { normal, shear_x, shear_y };

// One value of one packet: pressure_pa = (raw - zero) * gain_pa.
struct Field {
  std::size_t sensor = 0;             // index among the device's sensors
  Channel channel = Channel::normal;  // of the frame
  std::size_t taxel = 0;              // index in the layout
  std::size_t offset = 0;             // from the packet's begin, bytes
  NumberType type;                    // how the raw value is stored
  double zero = 0;                    // the raw value without load, counts
  double gain_pa = 1;                 // Pa per count, any sign
  std::uint32_t usage = 0;  // HID: page << 16 | usage whose descriptor gives offset, type, zero and scale;
                            // 0: the profile gives them
};

// A number that wraps around: the device's clock or its count of scans.
struct WrappingNumber {
  std::size_t offset = 0;   // from the packet's begin, bytes
  std::uint8_t bytes = 4;   // 1, 2, 4 or 8; it wraps at their largest number
  bool big_endian = false;  // false: least significant byte first
  double unit_ns = 1000;    // of a clock: ns per count; unused for a count of scans
};

// One packet of a scan.
struct PacketRule {
  std::uint32_t id = 0;                 // CAN identifier, report id, tag or first register
  std::optional<unsigned> board_shift;  // the board's number, shifted left by so many bits, is added to the
                                        // id; absent: the id contains no board
  std::size_t length = 0;               // of the packet, bytes; a packet of another length is malformed
  // Selects packets by one byte: (byte & mask) == value.
  struct {
    std::size_t offset = 0;  // from the packet's begin, bytes
    std::uint8_t mask = 0;   // 0: every packet of the id
    std::uint8_t value = 0;  // of the masked bits
  } match;
  std::vector<Field> fields;              // the values in the packet
  std::optional<WrappingNumber> clock;    // the device's time of the scan; absent: it sends none
  std::optional<WrappingNumber> counter;  // the device's count of scans; absent: it sends none
};

// A request on a USB device's control pipe. Data to the device are the message's bytes.
struct UsbControl {
  std::uint8_t type = 0;     // bmRequestType
  std::uint8_t request = 0;  // bRequest
  std::uint16_t value = 0;   // wValue
  std::uint16_t index = 0;   // wIndex
  std::uint16_t length = 0;  // of the device's answer, bytes; 0: it sends none
};

// What the driver sends to start or stop the device.
struct Message {
  std::uint32_t id = 0;                    // CAN identifier or report id; unused on USB
  std::optional<unsigned> board_shift;     // as in PacketRule
  std::vector<std::uint8_t> bytes;         // the data
  bool feature = false;                    // HID: a feature report; false: an output report
  std::optional<UsbControl> control = {};  // USB: a control request; absent: bytes to the endpoint
};

enum class ChecksumKind : std::uint8_t {
  none,         // the frame has no checksum
  sum8,         // sum of the bytes modulo 256
  xor8,         // exclusive or of the bytes
  lrc8,         // what makes the sum of the bytes 0 modulo 256
  sum16le,      // sum of the bytes modulo 65536, least significant byte first
  sum16be,      // the same, most significant byte first
  crc8,         // CRC of polynomial 0x07, one byte
  crc16modbus,  // CRC-16/MODBUS, least significant byte first
  crc16xmodem   // CRC-16/XMODEM (CCITT, start 0), most significant byte first
};

// Where the checksum is in a frame of a stream, and which bytes it covers. Negative: counted from the frame's
// end.
struct Checksum {
  ChecksumKind kind = ChecksumKind::none;
  std::ptrdiff_t at = 0;    // offset of the checksum, bytes
  std::ptrdiff_t from = 0;  // the first byte that it covers
  std::ptrdiff_t to = 0;    // the byte behind the last that it covers; 0: the frame's end
};

// A tagged value within a frame: a byte that equals the tag under the mask, then the value's bytes.
struct Record {
  std::uint8_t tag = 0;      // of the masked bits
  std::uint8_t mask = 0xFF;  // the bits that are compared
  std::size_t bytes = 0;     // of the value, without the tag
};

// How packets are cut out of a stream of bytes.
struct Stream {
  std::vector<std::uint8_t> begin;  // marker at the begin of every frame
  std::vector<std::uint8_t> end;    // marker at the end of every frame; empty: none
  std::size_t length = 0;           // of every frame, with markers, bytes; 0: frames differ in length
  // A byte of the frame that states its length.
  struct {
    std::size_t offset = 0;  // of that byte in the frame
    std::size_t plus = 0;    // bytes of the frame that it does not count; 0: frames have no such byte
  } length_byte;
  Checksum checksum;             // of each frame
  std::size_t longest = 0;       // length that no frame exceeds, bytes
  bool pts2 = false;             // the content has Contactile's nested offsets, see pts2.hpp
  std::size_t csv_values = 0;    // the content is a line of so many numbers, see csv_line.hpp; 0: it is not
  std::size_t records_from = 0;  // offset of the first record's tag in the frame, bytes
  std::vector<Record> records;   // the kinds of records; empty: the frame is one packet
};

// How a device is read over Modbus.
struct ModbusMap {
  int unit = 1;        // the slave's address, 0 … 255
  int function = 3;    // 3: holding registers, 4: input registers
  int tcp_port = 502;  // used where the configuration gives none
  int baud = 19200;    // RTU: bit/s, used where the configuration gives none
  char parity = 'N';   // RTU: N, E or O
};

// What a device that only answers is asked.
struct SerialRequest {
  std::vector<std::uint8_t> bytes;
  std::int64_t answer_within_ns = 0;  // else the rest of the round is left out
};

// A serial line; 8 data bits.
struct SerialLine {
  std::uint32_t baud = 115200;      // bit/s, used where the configuration gives none
  char parity = 'N';                // N, E or O
  int stop_bits = 1;                // 1 or 2
  bool rts_cts = false;             // flow control by RTS and CTS
  bool rs485 = false;               // the kernel switches the transceiver
  std::int64_t silence_ns = 0;      // a packet ends when so long nothing came; 0: silence means nothing
  std::vector<SerialRequest> poll;  // one round of requests; empty: the device sends by itself
};

// Which devices on USB or HID a profile describes.
struct HidMatch {
  std::uint16_t vendor = 0;   // vendor id; 0: any, on HID
  std::uint16_t product = 0;  // product id; 0: any, on HID
  std::uint32_t usage = 0;    // HID: page << 16 | usage of the device's top-level collection; 0: any
};

// How a device is read over USB.
struct UsbMatch {
  std::vector<HidMatch> devices;     // the vendor and product ids of the devices
  int interface = 0;                 // of the endpoints; the kernel's driver is detached from it
  std::uint8_t in = 0x81;            // bulk endpoint from the device
  std::uint8_t out = 0;              // bulk endpoint to the device; 0: none
  std::optional<int> cdc_interface;  // communication interface of a serial port (CDC-ACM); absent: not one
  std::uint32_t baud = 115200;       // of a serial port, bit/s
};

struct Profile {
  std::string description;                         // of the device, for people
  std::string tested;                              // synthetic, unverified or hardware
  std::string driver;                              // can, modbus, hid, serial or usb
  SensorClass sensor_class = SensorClass::array3;  // the channels that the device measures
  double rate_hz = 0;                              // scans per second
  std::size_t sensors = 1;                         // in one device, 1 … 16, all alike
  TaxelLayout layout = TaxelLayout::wrench(0.01);  // of each sensor
  SkinInfo skin;                                   // of each sensor
  std::int64_t scan_timeout_ns = 0;                // a scan that is incomplete after this is dropped
  std::optional<std::size_t> key_offset;  // offset of a byte that is equal in all packets of one scan;
                                          // absent: there is none
  std::optional<Stream> stream;           // absent: the bus delivers packets
  std::vector<PacketRule> scan;           // every packet of a scan, in the order of arrival
  std::vector<Message> start;             // sent on opening
  std::vector<Message> stop;              // sent on closing
  std::int64_t keep_alive_ns = 0;         // without a packet for this long `start` is sent again
  std::optional<ModbusMap> modbus;        // for driver modbus
  std::optional<HidMatch> hid;            // for driver hid
  std::optional<SerialLine> serial;       // for driver serial
  std::optional<UsbMatch> usb;            // for driver usb
  bool calibrated = true;                 // false: the values are no pressures, see SensorInfo
  bool zeroed = false;                    // the device's values are 0 without load, see SensorInfo
};

// Throws DriverError with one line for each error, `NAME: /json/pointer = value: what`.
Profile parse_profile(const std::string& text, const std::string& name);

// Reads NAME.json from /etc/slipd/profiles, else from the folder `profiles` beside that of the program or
// module with this code (a build tree), else from the installed data. Throws DriverError, which names the
// folders.
Profile find_profile(const std::string& name);

// The description of a sensor of this profile. `part`: see SensorInfo.
SensorInfo info_of(const Profile& profile, std::string part);

// The names of all profiles in those folders, sorted.
std::vector<std::string> profile_names();

// The profile of the sensors of one device. Throws DriverError unless all of them name the same one and it is
// for that driver.
Profile profile_of(const std::vector<SensorSetup>& sensors, const std::string& driver);

}  // namespace slipd::decode
