// Each device's format, byte by byte. Expected bytes were worked out by hand from the layouts in the models.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/devices/contacts.hpp"

namespace slipd::devices {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

// One scan of the contact `pattern`, at scan 0x12 and 0x3456 µs.
std::vector<Packet> scan_of(const DeviceModel& model) {
  std::vector<std::vector<float>> memory;
  std::vector<Frame> frames;
  for (const Contact& contact : pattern(model)) {
    const std::size_t taxels = model.layout.size();
    std::vector<float>& values = memory.emplace_back(3 * taxels);
    FrameSlot slot;
    slot.normal_pa = std::span(values).subspan(0, taxels);
    slot.shear_x_pa = std::span(values).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(values).subspan(2 * taxels, taxels);
    contact(slot);
    frames.push_back(slot.view());
  }
  return model.scan({frames, 0x12, 0x3456});
}

Bytes part(const Bytes& bytes, std::size_t at, std::size_t size) {
  return Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(at),
               bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
}

// A scan has the same length for a sensor at rest and for one beyond every limit.
class EveryDevice : public ::testing::TestWithParam<const DeviceModel*> {};
INSTANTIATE_TEST_SUITE_P(Devices, EveryDevice, ::testing::ValuesIn(all_models()), [](const auto& tested) {
  std::string name(tested.param->name);
  std::ranges::replace(name, '-', '_');
  return name;
});

TEST_P(EveryDevice, KeepsTheLengthOfAScanWhateverItFeels) {
  const DeviceModel& model = *GetParam();
  const std::vector<Packet> usual = scan_of(model);
  for (const float pressure : {0.0F, 1e9F, -1e9F}) {
    const std::vector<float> values(model.layout.size(), pressure);
    const std::vector<Frame> frames(model.sensors, Frame{0, 0, values, values, values});
    const std::vector<Packet> scan = model.scan({frames, 1, 2});
    ASSERT_EQ(scan.size(), usual.size());
    for (std::size_t i = 0; i < scan.size(); ++i) {
      EXPECT_EQ(scan[i].address, usual[i].address);
      EXPECT_EQ(scan[i].bytes.size(), usual[i].bytes.size());
    }
  }
}

TEST_P(EveryDevice, IsFoundByItsName) {
  EXPECT_EQ(find_model(GetParam()->name), GetParam());
}

TEST(Xela, SendsAFrameATaxelWithBigEndianAxesFromByteOne) {
  const auto scan = scan_of(xela_xr1944());
  ASSERT_THAT(scan, SizeIs(16));
  // Taxel 0: 1000 Pa normal is 25 counts, 500 Pa shear 25, -250 Pa shear -12.5, about 30000 = 0x7530.
  EXPECT_EQ(scan[0], (Packet{0x710, {0, 0x75, 0x49, 0x75, 0x24, 0x75, 0x49}}));
  // Taxel 15: 16000 Pa is 400, 8000 is 400, -4000 is -200.
  EXPECT_EQ(scan[15], (Packet{0x71F, {0, 0x76, 0xC0, 0x74, 0x68, 0x76, 0xC0}}));
}

TEST(Xela, SendsOnlyAfterItsStartCommand) {
  HostState host{.streaming = xela_xr1944().starts_by_itself};
  EXPECT_FALSE(host.streaming);
  xela_xr1944().receive({0x202, {0x07, 0x00}}, host);
  EXPECT_FALSE(host.streaming) << "that was for another board";
  xela_xr1944().receive({0x201, {0x07, 0x00}}, host);
  EXPECT_TRUE(host.streaming);
}

TEST(ICubSkin, SendsSevenTaxelsThenFiveOfEachTriangle) {
  const auto scan = scan_of(icub_skin());
  ASSERT_THAT(scan, SizeIs(8));
  // Taxels 1…12 sense 1000 … 12000 Pa: 2 counts each, down from 245.
  EXPECT_EQ(scan[0], (Packet{0x410, {0x00, 243, 241, 239, 237, 235, 233, 231}}));
  EXPECT_EQ(scan[1], (Packet{0x410, {0x80, 229, 227, 225, 223, 221, 0, 0}}));
  EXPECT_EQ(scan[2].address, 0x411);
  EXPECT_EQ(scan[7], (Packet{0x413, {0x80, 157, 155, 153, 151, 149, 0, 0}}));
}

TEST(ICubSkin, StartsAndStopsByItsTransmissionMode) {
  HostState host;
  icub_skin().receive({0x201, {0x07, 0x00}}, host);
  EXPECT_TRUE(host.streaming);
  icub_skin().receive({0x201, {0x07, 0x01}}, host);
  EXPECT_FALSE(host.streaming);
}

TEST(TakkTile, SendsTenBitsLeftAlignedForPressureAndTemperature) {
  const auto scan = scan_of(takktile());
  ASSERT_THAT(scan, SizeIs(1));
  EXPECT_EQ(scan[0].address, 0x81);
  ASSERT_THAT(scan[0].bytes, SizeIs(40 * 4));
  // 394 - 1000 / 127.3 = 386 = 0x182, << 6 = 0x6080; 472 << 6 = 0x7600.
  EXPECT_THAT(part(scan[0].bytes, 0, 4), ElementsAre(0x60, 0x80, 0x76, 0x00));
  // 394 - 40000 / 127.3 = 80 = 0x50, << 6 = 0x1400.
  EXPECT_THAT(part(scan[0].bytes, 156, 4), ElementsAre(0x14, 0x00, 0x76, 0x00));
}

TEST(TakkTile, AnswersForItsCellsAndStartsByRequest) {
  HostState host;
  const auto ask = [&](std::uint8_t request, std::uint16_t value) {
    return takktile().usb->request({0xC0, request, value, 0, 64}, host);
  };
  EXPECT_EQ(ask(0x5C, 0), Bytes(40, 255));
  EXPECT_THAT(*ask(0x6C, 0), SizeIs(8));
  EXPECT_TRUE(ask(0xC7, 100));
  EXPECT_TRUE(host.streaming);
  EXPECT_TRUE(ask(0xC7, 0));
  EXPECT_FALSE(host.streaming);
  EXPECT_FALSE(ask(0x11, 0)) << "an unknown request stalls";
}

TEST(PapillArray, FramesTheSameOffsetsAsARecordedStream) {
  const auto scan = scan_of(papillarray());
  ASSERT_THAT(scan, SizeIs(1));
  const Bytes& bytes = scan[0].bytes;
  // Start marker, W, the table of six blocks, two zeros: as a hub with two sensors of nine pillars sends
  // them.
  EXPECT_THAT(part(bytes, 0, 31),
              ElementsAre(0x55, 0x66, 0x77, 0x88, 0x02, 0x01, 0x00, 0x1b, 0x00, 0x03, 0x00, 0x27, 0x00, 0x04,
                          0x00, 0x29, 0x02, 0x05, 0x00, 0x63, 0x02, 0x06, 0x00, 0x0f, 0x03, 0x07, 0x00, 0x2b,
                          0x03, 0x00, 0x00));
  EXPECT_THAT(part(bytes, 31, 12), ElementsAre(0x12, 0, 0, 0, 0x56, 0x34, 0, 0, 0, 0, 0, 0));  // counter, µs
  // T3: two sensors at 0x2d and 0x12b; the first has nine pillars from 0x41, 26 bytes apart.
  EXPECT_THAT(part(bytes, 43, 16),
              ElementsAre(2, 0, 0x2d, 0, 0x2b, 1, 9, 0, 0x41, 0, 0x5b, 0, 0x75, 0, 0x8f, 0));
  EXPECT_THAT(part(bytes, bytes.size() - 4, 4), ElementsAre(0xAA, 0xBB, 0xCC, 0xDD));
}

TEST(PapillArray, GivesEachPillarItsForceInNewton) {
  const Bytes bytes = scan_of(papillarray())[0].bytes;
  // Pillar 0 of sensor 0 at 0x41 after the marker: u16 2, then 1000 Pa on 49 mm²: x 24.5 mN, y -12.25 mN,
  // z 49 mN.
  EXPECT_THAT(part(bytes, 4 + 0x41, 2), ElementsAre(2, 0));
  const std::vector<float> expected{0.0245F, -0.01225F, 0.049F, 0.01225F, -0.006125F, 0.0245F};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    float value = 0;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(4 + 0x41 + 2 + 4 * i), 4,
                reinterpret_cast<std::uint8_t*>(&value));
    EXPECT_NEAR(value, expected[i], 1e-7) << i;
  }
}

TEST(PapillArray, SumsItsData) {
  const Bytes bytes = scan_of(papillarray())[0].bytes;
  const Bytes data = part(bytes, 4, bytes.size() - 10);
  const unsigned sum = std::accumulate(data.begin(), data.end(), 0U) & 0xFFFFU;
  EXPECT_THAT(part(bytes, bytes.size() - 6, 2), ElementsAre(sum & 0xFF, sum >> 8));
}

TEST(Tsf85, SendsAPacketAFingerAndOneForTheRest) {
  const auto scan = scan_of(robotiq_tsf85());
  ASSERT_THAT(scan, SizeIs(3));
  ASSERT_THAT(scan[0].bytes, SizeIs(4 + 1 + 56));
  // 9A, crc, command, length 57, tag of finger 0; 1000 Pa are 50 counts, 2000 are 100.
  EXPECT_THAT(part(scan[0].bytes, 2, 7), ElementsAre(0x58, 57, 0x10, 0, 50, 0, 100));
  EXPECT_EQ(scan[0].bytes[0], 0x9A);
  // Finger 1 has tag 0x14 and senses 100 Pa more.
  EXPECT_THAT(part(scan[1].bytes, 2, 7), ElementsAre(0x58, 57, 0x14, 0, 55, 0, 105));
  // Vibration of both, and the time.
  EXPECT_THAT(part(scan[2].bytes, 2, 17),
              ElementsAre(0x58, 15, 0x20, 0, 0, 0x24, 0, 0, 0x70, 0, 0, 0, 0, 0, 0, 0x34, 0x56));
}

TEST(Tsf85, StartsAndStopsByItsPeriod) {
  HostState host;
  robotiq_tsf85().receive({1, {0x9A, 0, 0x58, 1, 1}}, host);
  EXPECT_TRUE(host.streaming);
  robotiq_tsf85().receive({1, {0x9A, 0, 0x58, 1, 0}}, host);
  EXPECT_FALSE(host.streaming);
}

TEST(VendorHid, SplitsAScanOverReportsOf64Bytes) {
  const auto scan = scan_of(vendor_hid());
  ASSERT_THAT(scan, SizeIs(7));
  // Scan 0x12, part 0 of 7 with ten taxels; 1000 Pa are 200 counts, 500 are 100, -250 are -50.
  EXPECT_THAT(part(scan[0].bytes, 0, 10), ElementsAre(0x12, 0, 7, 10, 200, 0, 100, 0, 0xCE, 0xFF));
  EXPECT_THAT(part(scan[6].bytes, 0, 4), ElementsAre(0x12, 6, 7, 4));
  for (const Packet& report : scan) EXPECT_THAT(report.bytes, SizeIs(64));
}

TEST(Rg2Ft, PutsBothFingersIntoItsRegisters) {
  const auto scan = scan_of(onrobot_rg2ft());
  ASSERT_THAT(scan, SizeIs(1));
  EXPECT_EQ(scan[0].address, 257);
  ASSERT_THAT(scan[0].bytes, SizeIs(2 * 26));
  // 1000 Pa on (18 mm)² are 0.324 N: 3 tenths; shear 0.162 N and -0.081 N.
  EXPECT_THAT(part(scan[0].bytes, 2 * 2, 6), ElementsAre(0, 2, 0xFF, 0xFF, 0, 3));
  EXPECT_THAT(part(scan[0].bytes, 2 * 11, 6), ElementsAre(0, 2, 0xFF, 0xFF, 0, 4));
  EXPECT_THAT(part(scan[0].bytes, 2 * 23, 6), ElementsAre(0x01, 0x2C, 0, 0, 0, 1));
}

TEST(Ft300, GivesHundredthsOfANewton) {
  const auto scan = scan_of(robotiq_ft300());
  ASSERT_THAT(scan, SizeIs(1));
  EXPECT_EQ(scan[0].address, 180);
  // 1000 Pa on (20 mm)² are 0.4 N.
  EXPECT_THAT(scan[0].bytes, ElementsAre(0, 20, 0xFF, 0xF6, 0, 40, 0, 0, 0, 0, 0, 0));
}

TEST(OptoForce, SendsSixteenBytesWithTheirSum) {
  const auto scan = scan_of(optoforce());
  ASSERT_THAT(scan, SizeIs(1));
  // 1000 Pa on a square centimetre are 0.1 N: 10 counts; shear 5 and -2.5. The sum is 10 + 5 + 0xFF + 0xFD +
  // …
  EXPECT_THAT(scan[0].bytes, ElementsAre(0xAA, 7, 8, 10, 0, 0x12, 0, 0, 0, 5, 0xFF, 0xFD, 0, 10, 2, 0xE0));
}

TEST(SpaceMouse, SendsItsTranslationInReportOne) {
  EXPECT_THAT(scan_of(space_mouse()),
              ElementsAre(Packet{1, {5, 0, 0xFD, 0xFF, 10, 0}}, Packet{2, Bytes(6, 0)}));
}

TEST(RoHand, GivesEachFingersForceInMillinewton) {
  const auto scan = scan_of(rohand());
  ASSERT_THAT(scan, SizeIs(1));
  EXPECT_EQ(scan[0].address, 1120);
  // 1000 Pa on (15 mm)² are 225 mN; each finger senses 100 Pa more than the one before.
  EXPECT_THAT(scan[0].bytes, ElementsAre(0, 225, 0, 248, 1, 14, 1, 37, 1, 59));
}

}  // namespace
}  // namespace slipd::devices
