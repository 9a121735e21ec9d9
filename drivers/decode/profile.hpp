// A device profile: what a device sends, where its taxels are, how it is started. config/profile.schema.json
// says what each key means; here it is checked and in SI units, laid out for the decoder. Set-up thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/decode/number.hpp"

namespace slipd::decode {

enum class Channel : std::uint8_t { normal, shear_x, shear_y };

// One value of one packet: pressure_pa = (raw - zero) * gain_pa.
struct Field {
  std::size_t sensor = 0;
  Channel channel = Channel::normal;
  std::size_t taxel = 0;
  std::size_t offset = 0;  // bytes
  NumberType type;
  double zero = 0;
  double gain_pa = 1;
  std::uint32_t usage = 0;  // on HID: the device itself says offset, type, zero and gain of this usage; 0: no
};

// A number that goes round: the device's clock or its count of scans. It is (raw * unit_ns) ns, or scans.
struct RoundNumber {
  std::size_t offset = 0;
  std::uint8_t bytes = 4;
  bool big_endian = false;
  double unit_ns = 1000;
};

// One packet of a scan. `board_shift`: the board's number shifted so far left is added to the id.
struct PacketRule {
  std::uint32_t id = 0;
  std::optional<unsigned> board_shift;
  std::size_t length = 0;  // bytes
  struct {
    std::size_t offset = 0;
    std::uint8_t mask = 0, value = 0;  // mask 0: any packet of the id
  } match;
  std::vector<Field> fields;
  std::optional<RoundNumber> clock, counter;
};

// A request on a USB device's control pipe. Data to the device is the message's bytes.
struct UsbControl {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;  // length: of the answer
};

struct Message {
  std::uint32_t id = 0;
  std::optional<unsigned> board_shift;
  std::vector<std::uint8_t> bytes;
  bool feature = false;  // of HID
  std::optional<UsbControl> control = {};
};

enum class Sum : std::uint8_t { none, sum16le, sum16be, crc8 };

// Where a checksum stands in a frame of a stream, and over which bytes it goes; negative: from the frame's
// end.
struct Checksum {
  Sum kind = Sum::none;
  std::ptrdiff_t at = 0, from = 0, to = 0;  // to: one behind the last; 0 is the frame's end
};

// A tagged value within a frame: a byte that under the mask is the tag, then so many bytes.
struct Record {
  std::uint8_t tag = 0, mask = 0xFF;
  std::size_t bytes = 0;
};

// How packets are cut out of a stream of bytes.
struct Stream {
  std::vector<std::uint8_t> begin, end;  // markers; end may be empty
  std::size_t length = 0;                // of every frame, markers and all; 0: the frames say it
  struct {
    std::size_t offset = 0, plus = 0;  // a byte at `offset`, and what it leaves out; plus 0: there is none
  } length_byte;
  Checksum checksum;
  std::size_t longest = 0;
  bool pts2 = false;  // Contactile's nested offsets, see pts2.hpp
  std::size_t records_from = 0;
  std::vector<Record> records;  // none: the frame is one packet
};

struct ModbusMap {
  int unit = 1;
  int function = 3;
  int tcp_port = 502;
  int baud = 19200;
  char parity = 'N';
};

struct HidMatch {
  std::uint16_t vendor = 0, product = 0;  // 0: any, on HID
  std::uint32_t usage = 0;                // page << 16 | usage of the whole device, on HID; 0: any
};

struct UsbMatch {
  std::vector<HidMatch> devices;
  int interface = 0;
  std::uint8_t in = 0x81, out = 0;   // endpoints; out 0: the device is only listened to
  std::optional<int> cdc_interface;  // of a serial port: where its line state and coding are set
  std::uint32_t baud = 115200;
};

struct Profile {
  std::string description, tested, driver;
  SensorClass sensor_class = SensorClass::array3;
  double rate_hz = 0;
  std::size_t sensors = 1;
  TaxelLayout layout = TaxelLayout::wrench(0.01);
  SkinInfo skin;
  std::int64_t scan_timeout_ns = 0;
  std::optional<std::size_t> key_offset;  // of a byte that is the same in all packets of a scan
  std::optional<Stream> stream;           // none: packets arrive as such
  std::vector<PacketRule> scan;           // every packet of a scan, in the order in which they come
  std::vector<Message> start, stop;
  std::int64_t keep_alive_ns = 0;
  std::optional<ModbusMap> modbus;
  std::optional<HidMatch> hid;
  std::optional<UsbMatch> usb;
  bool zeroed = false;  // the device does that itself, see SensorInfo
};

// Throws DriverError: a line for each thing that is wrong, `NAME: /json/pointer = value: what`.
Profile parse_profile(const std::string& text, const std::string& name);

// NAME.json of /etc/slipd/profiles, else of the folder `profiles` beside that of the program or module this
// code is in (a build tree), else of the installed data. Throws DriverError, which says where it looked.
Profile find_profile(const std::string& name);

// What a driver says of a sensor of this profile. `part`: see SensorInfo.
SensorInfo info_of(const Profile& profile, std::string part);

// Of all profiles in those folders, sorted.
std::vector<std::string> profile_names();

// The profile that all of these sensors name, for that driver. Throws DriverError.
Profile profile_of(const std::vector<SensorSetup>& sensors, const std::string& driver);

}  // namespace slipd::decode
