// slipctl probe and decode: the devices of a machine, from a sysfs of the test's own, and captures of
// simulated devices.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "driver_api/driver.hpp"
#include "tests/devices/contacts.hpp"
#include "tests/support/temp_folder.hpp"
#include "tools/slipctl/decode.hpp"
#include "tools/slipctl/probe.hpp"

namespace slipctl {
namespace {

using nlohmann::json;
using slipd::devices::DeviceModel;
using slipd::devices::Packet;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Machine {
 public:
  void file(const std::string& path, const std::string& text) const {
    const auto whole = folder_.path() / path;
    std::filesystem::create_directories(whole.parent_path());
    std::ofstream(whole) << text << '\n';
  }
  json probed() const { return probe(folder_.path()); }

 private:
  slipd::testing::TempFolder folder_;
};

TEST(Probe, FindsNothingOnAMachineThatHasNothing) {
  EXPECT_THAT(Machine().probed(), IsEmpty());
}

TEST(Probe, NamesTheProfileOfAUsbDeviceAndHowToTellItFromItsLike) {
  const Machine machine;
  for (const auto& [port, serial] : {std::pair{"1-1", "42"}, {"1-2.3", ""}}) {
    const std::string at = std::string("bus/usb/devices/") + port + "/";
    machine.file(at + "idVendor", "16c0");
    machine.file(at + "idProduct", "0483");
    machine.file(at + "bDeviceClass", "02");
    if (*serial != '\0') machine.file(at + "serial", serial);
  }
  machine.file("bus/usb/devices/usb1/idVendor", "1d6b");
  machine.file("bus/usb/devices/usb1/bDeviceClass", "09");
  machine.file("bus/usb/devices/1-1:1.0/bInterfaceClass", "0a");
  const json found = machine.probed();
  ASSERT_EQ(found.size(), 2) << "neither hubs nor interfaces: " << found;
  EXPECT_EQ(found[0]["id"], "16c0:0483");
  EXPECT_EQ(found[0]["profiles"], json({"contactile-pts2"}));
  EXPECT_EQ(found[0]["device"], json({{"serial", "42"}}));
  EXPECT_EQ(found[1]["device"], json({{"port", "1-2.3"}}));
}

TEST(Probe, FindsHidDevicesCanInterfacesAndSerialLines) {
  const Machine machine;
  machine.file("class/hidraw/hidraw3/device/uevent",
               "HID_ID=0003:0000256F:0000C635\nHID_NAME=Mouse\nHID_UNIQ=");
  machine.file("class/hidraw/hidraw4/device/uevent", "HID_ID=0003:0000046D:0000C31C\nHID_NAME=Keyboard");
  machine.file("class/net/can0/type", "280");
  machine.file("class/net/eth0/type", "1");
  machine.file("class/tty/ttyUSB0/dev", "188:0");
  const json found = machine.probed();
  ASSERT_EQ(found.size(), 5) << found;
  EXPECT_EQ(found[0]["profiles"], json({"3dconnexion"}));
  EXPECT_EQ(found[0]["device"], json({{"path", "/dev/hidraw3"}}));
  EXPECT_THAT(found[1]["profiles"], Contains("xela-xr1944"));
  EXPECT_EQ(found[1]["device"], json({{"interface", "can0"}}));
  EXPECT_THAT(found[2]["profiles"], Contains("anyskin"));
  EXPECT_EQ(found[2]["device"], json({{"path", "/dev/ttyUSB0"}}));
  EXPECT_THAT(found[3]["profiles"], Contains("robotiq-ft300"));
  EXPECT_EQ(found[4]["name"], "Keyboard") << "what no profile matches comes last";
  EXPECT_THAT(found[4]["profiles"], IsEmpty());
}

// The bytes that a device sends in `scans` scans of the pattern of the models' tests.
std::vector<Packet> packets_of(const DeviceModel& model, int scans) {
  const std::size_t taxels = model.layout.size();
  std::vector<std::vector<float>> memory;
  std::vector<slipd::Frame> frames;
  for (const auto& contact : pattern(model)) {
    auto& values = memory.emplace_back(3 * taxels);
    slipd::FrameSlot slot;
    slot.normal_pa = std::span(values).first(taxels);
    slot.shear_x_pa = std::span(values).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(values).last(taxels);
    contact(slot);
    frames.push_back(slot.view());
  }
  std::vector<Packet> out;
  for (int scan = 0; scan < scans; ++scan) {
    for (Packet& packet : model.scan({frames, static_cast<std::uint64_t>(scan), 10000U * scan}))
      out.push_back(std::move(packet));
  }
  return out;
}

std::string bytes_of(const std::vector<Packet>& packets, bool numbered = false) {
  std::string out;
  for (const Packet& packet : packets) {
    if (numbered) out += static_cast<char>(packet.address);
    out.append(packet.bytes.begin(), packet.bytes.end());
  }
  return out;
}

struct Decoded {
  bool any;
  std::vector<json> frames;
  std::string remarks;
};

Decoded said_of(const std::string& profile, const std::string& capture) {
  std::istringstream in(capture);
  std::ostringstream out, remarks;
  Decoded said{decode({profile, 1, true}, in, out, remarks), {}, remarks.str()};
  std::istringstream lines(out.str());
  for (std::string line; std::getline(lines, line);) said.frames.push_back(json::parse(line));
  return said;
}

TEST(Decode, CutsFramesOutOfAUsbCaptureAndSaysWhatItDropped) {
  std::string capture = bytes_of(packets_of(slipd::devices::papillarray(), 3));
  capture.insert(capture.size() / 3, "dirt");
  const Decoded said = said_of("contactile-pts2", capture);
  EXPECT_TRUE(said.any);
  ASSERT_EQ(said.frames.size(), 6) << "two sensors";
  EXPECT_EQ(said.frames[5]["sensor"], 1);
  EXPECT_EQ(said.frames[5]["seq"], 2);
  EXPECT_EQ(said.frames[5]["device_time_ns"], 20'000'000);
  EXPECT_NEAR(said.frames[0]["normal_pa"][8].get<double>(), 9000, 1);
  EXPECT_THAT(said.remarks, HasSubstr("6 frames, 1 dropped, 4 bytes of no frame"));
}

TEST(Decode, ReadsCanAsCandumpWritesIt) {
  std::string capture;
  for (const Packet& packet : packets_of(slipd::devices::xela_xr1944(), 2)) {
    char text[64];
    int size = std::snprintf(text, sizeof text, "(1436509052.%06d) can0 %X#", 100, packet.address);
    for (const auto byte : packet.bytes) size += std::snprintf(text + size, 3, "%02X", byte);
    capture += std::string(text) + "\n";
  }
  EXPECT_EQ(said_of("xela-xr1944", capture + "nonsense\n(1.0) can0 123#00\n(1.0) can0 zz#1\n").frames.size(),
            2);
}

TEST(Decode, ReadsReportsAndRegistersInTheirOrder) {
  EXPECT_EQ(said_of("vendor-hid-8x8", bytes_of(packets_of(slipd::devices::vendor_hid(), 2))).frames.size(),
            2);
  EXPECT_EQ(
      said_of("3dconnexion", bytes_of(packets_of(slipd::devices::space_mouse(), 2), true)).frames.size(), 2);
  EXPECT_EQ(said_of("oymotion-rohand", bytes_of(packets_of(slipd::devices::rohand(), 2))).frames.size(), 10);
}

TEST(Decode, FailsWithoutAFrameAndWithoutAProfile) {
  EXPECT_FALSE(said_of("optoforce", "nothing of use").any);
  EXPECT_FALSE(said_of("vendor-hid-8x8", "").any);
  EXPECT_THROW(said_of("nobodys", ""), slipd::DriverError);
}

}  // namespace
}  // namespace slipctl
