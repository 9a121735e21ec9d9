// Packets → frames: the bytes that the sources state, what simulated devices send, and what no device should.
#include "drivers/decode/decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>

#include "drivers/decode/framer.hpp"
#include "tests/devices/bytes.hpp"
#include "tests/devices/device_model.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd::decode {
namespace {

using devices::Bytes;
using devices::Packet;
using testing::Each;
using testing::FloatNear;

constexpr std::int64_t kMs = 1'000'000;

// A decoder with its slot, fed by the clock that the test says.
class DecoderRig {
 public:
  explicit DecoderRig(const std::string& profile, std::size_t sensor = 0, unsigned board = 1)
      : profile_(find_profile(profile)),
        framer_(profile_),
        decoder(profile_, sensor, board),
        out(profile_.layout.size()) {}

  Outcome take(const Packet& packet, std::int64_t time_ns = 0) {
    return decoder.take(packet.address, packet.bytes, time_ns, out.slot);
  }

  // How many frames came of these packets, 0.1 ms apart. On USB they are transfers, and a packet's address is
  // the endpoint's.
  int frames(const std::vector<Packet>& packets) {
    int count = 0;
    for (const Packet& packet : packets) {
      now_ns_ += kMs / 10;
      if (profile_.driver != "usb") {
        count += take(packet, now_ns_) == Outcome::frame ? 1 : 0;
        continue;
      }
      framer_.put(packet.bytes);
      RawPacket raw;
      while (framer_.next(raw) == Framer::Result::packet)
        count += decoder.take(raw.id, raw.bytes, now_ns_, out.slot) == Outcome::frame ? 1 : 0;
    }
    now_ns_ += 5 * kMs;
    return count;
  }

 private:
  Profile profile_;
  Framer framer_;
  std::int64_t now_ns_ = 0;

 public:
  Decoder decoder;
  test::OwnedSlot out;
};

// What the model's device sends when each taxel senses 1000 Pa times its number from 1, half in x, a quarter
// in -y.
std::vector<Packet> scan_of(const devices::DeviceModel& model) {
  std::vector<test::OwnedSlot> slots;
  std::vector<Frame> frames;
  for (std::size_t sensor = 0; sensor < model.sensors; ++sensor) {
    auto& slot = slots.emplace_back(model.layout.size()).slot;
    for (std::size_t i = 0; i < model.layout.size(); ++i) {
      slot.normal_pa[i] = 1000 * static_cast<float>(i + 1 + sensor);
      slot.shear_x_pa[i] = slot.normal_pa[i] / 2;
      slot.shear_y_pa[i] = -slot.normal_pa[i] / 4;
    }
  }
  for (auto& slot : slots) frames.push_back(slot.slot.view());
  return model.scan({frames, 0, 0});
}

TEST(Decoder, ReadsTheXelasBigEndianAxes) {
  DecoderRig rig("xela-xr1944");
  for (std::uint32_t taxel = 0; taxel < 15; ++taxel)
    EXPECT_EQ(rig.take({0x710 + taxel, {0, 0x75, 0x30, 0x75, 0x30, 0x75, 0x30}}, taxel), Outcome::partial);
  EXPECT_EQ(rig.take({0x71F, {0xFF, 0x75, 0x31, 0x75, 0x2E, 0x76, 0x30}}, 20), Outcome::frame);
  EXPECT_FLOAT_EQ(rig.out.slot.shear_x_pa[15], 20);
  EXPECT_FLOAT_EQ(rig.out.slot.shear_y_pa[15], -40);
  EXPECT_FLOAT_EQ(rig.out.slot.normal_pa[15], 256 * 40);
  EXPECT_THAT(std::vector(rig.out.slot.normal_pa.begin(), rig.out.slot.normal_pa.end() - 1), Each(0));
  EXPECT_EQ(rig.out.slot.time_ns, 0) << "the scan's first packet is nearest to the sample";
}

TEST(Decoder, ReadsTheTwoHalvesOfTheIcubsTrianglesAndGivesNoShear) {
  DecoderRig rig("icub-mtb");
  for (std::uint32_t triangle = 0; triangle < 4; ++triangle) {
    EXPECT_EQ(rig.take({0x410 + triangle, {0x00, 245, 244, 245, 245, 245, 245, 245}}), Outcome::partial);
    rig.take({0x410 + triangle, {0x80, 245, 245, 245, 245, 0, 0, 0}});
  }
  EXPECT_EQ(rig.decoder.counts().malformed, 0);
  EXPECT_FLOAT_EQ(rig.out.slot.normal_pa[1], 500);
  EXPECT_FLOAT_EQ(rig.out.slot.normal_pa[11], 245 * 500);
  EXPECT_THAT(rig.out.slot.shear_x_pa, Each(0));
}

TEST(Decoder, ReadsBothFingersOfTheRg2ftEachForItself) {
  Bytes registers(52, 0);
  registers[8] = 0x00, registers[9] = 0x32;    // left z: 50 = 5.0 N
  registers[22] = 0xFF, registers[23] = 0xF6;  // right x: -10 = -1.0 N
  DecoderRig left("onrobot-rg2-ft", 0), right("onrobot-rg2-ft", 1);
  EXPECT_EQ(left.take({257, registers}), Outcome::frame);
  EXPECT_EQ(right.take({257, registers}), Outcome::frame);
  const double area_m2 = 0.018 * 0.018;
  EXPECT_NEAR(left.out.slot.normal_pa[0] * area_m2, 5.0, 1e-6);
  EXPECT_NEAR(left.out.slot.shear_x_pa[0], 0, 1e-6);
  EXPECT_NEAR(right.out.slot.shear_x_pa[0] * area_m2, -1.0, 1e-6);
}

// What the makers' own readers do with the same bytes, written down from them:
//   anyskin/sensor.py of AnySkin, which eFlesh's slip detection uses, too: struct.unpack("@{4 n}fcc"), of
//   each chip's four values all but the first, which is its temperature; the message is thrown away unless it
//   ends in CR LF.
std::vector<float> of_makers_reader(const Bytes& message) {
  std::vector<float> out;
  for (std::size_t at = 0; at + 4 <= message.size() - 2; at += 4) {
    float value = 0;
    std::memcpy(&value, message.data() + at, sizeof value);
    if (at % 16 != 0) out.push_back(value);
  }
  return out;
}

TEST(Decoder, ReadsOfAnyBytesWhatTheMakersReaderReadsValueByValue) {
  std::mt19937 bits(1);
  DecoderRig left("eflesh", 0), right("eflesh", 1);
  for (int frame = 0; frame < 1000; ++frame) {
    Bytes message;
    for (int i = 0; i < 40; ++i) {
      // Any sign, exponent and fraction of a number of at most 1e9.
      const auto exponent = static_cast<std::uint32_t>(bits() % 157);
      const auto rest = static_cast<std::uint32_t>(bits()) & 0x807FFFFFU;
      devices::put_le(message, std::bit_cast<float>(rest | exponent << 23));
    }
    devices::append(message, {'\r', '\n'});
    const std::vector<float> wanted = of_makers_reader(message);
    for (std::size_t pad = 0; pad < 2; ++pad) {
      DecoderRig& rig = pad == 0 ? left : right;
      ASSERT_EQ(rig.take({0, message}), Outcome::frame);
      for (std::size_t chip = 0; chip < 5; ++chip) {
        const float* const of_chip = &wanted[3 * (5 * pad + chip)];
        EXPECT_EQ(rig.out.slot.shear_x_pa[chip], of_chip[0]);
        EXPECT_EQ(rig.out.slot.shear_y_pa[chip], of_chip[1]);
        EXPECT_EQ(rig.out.slot.normal_pa[chip], of_chip[2]);
      }
    }
  }
}

// Simulated devices do not use profiles. The tolerance is half a count.
struct Pair {
  const devices::DeviceModel& (*model)();
  const char* profile;
  float half_count_pa;
};
class AgreesWithTheDevice : public testing::TestWithParam<Pair> {};

TEST_P(AgreesWithTheDevice, TaxelByTaxel) {
  const auto& [model, name, half_count_pa] = GetParam();
  for (std::size_t sensor = 0; sensor < model().sensors; ++sensor) {
    DecoderRig rig(name, sensor);
    ASSERT_EQ(rig.frames(scan_of(model())), 1);
    const bool shear = model().sensor_class != SensorClass::normal;
    for (std::size_t i = 0; i < model().layout.size(); ++i) {
      const float normal_pa = 1000 * static_cast<float>(i + 1 + sensor);
      EXPECT_NEAR(rig.out.slot.normal_pa[i], normal_pa, half_count_pa) << i;
      EXPECT_NEAR(rig.out.slot.shear_x_pa[i], shear ? normal_pa / 2 : 0, half_count_pa) << i;
      EXPECT_NEAR(rig.out.slot.shear_y_pa[i], shear ? -normal_pa / 4 : 0, half_count_pa) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sheets, AgreesWithTheDevice,
                         testing::Values(Pair{devices::xela_xr1944, "xela-xr1944", 20.1F},
                                         Pair{devices::icub_skin, "icub-mtb", 250.1F},
                                         Pair{devices::onrobot_rg2ft, "onrobot-rg2-ft", 154.5F},
                                         Pair{devices::robotiq_ft300, "robotiq-ft300", 12.6F},
                                         Pair{devices::vendor_hid, "vendor-hid-8x8", 2.6F},
                                         Pair{devices::papillarray, "contactile-pts2", 0.1F},
                                         Pair{devices::robotiq_tsf85, "robotiq-tsf85", 10.1F},
                                         Pair{devices::takktile, "takktile", 63.7F},
                                         Pair{devices::optoforce, "optoforce", 50.1F},
                                         Pair{devices::space_mouse, "3dconnexion", 50.1F},
                                         Pair{devices::rohand, "oymotion-rohand", 2.3F},
                                         Pair{devices::anyskin, "anyskin", 0.01F}),
                         [](const auto& tested) {
                           std::string name = std::string("as_") + tested.param.profile;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(Decoder, DropsTheScanWholeIfAPacketIsLostAndSaysSoInTheSequence) {
  for (const std::size_t lost : {0U, 7U, 15U}) {
    DecoderRig rig("xela-xr1944");
    const auto whole = scan_of(devices::xela_xr1944());
    auto broken = whole;
    broken.erase(broken.begin() + static_cast<std::ptrdiff_t>(lost));
    EXPECT_EQ(rig.frames(whole), 1);
    EXPECT_EQ(rig.out.slot.sequence, 0);
    EXPECT_EQ(rig.frames(broken), 0);
    EXPECT_EQ(rig.frames(whole), 1);
    if (lost == 0) {
      EXPECT_EQ(rig.decoder.counts().stray, 15) << "nothing tells how many scans began in what was lost";
    } else {
      EXPECT_EQ(rig.out.slot.sequence, 2);
      EXPECT_EQ(rig.decoder.counts().incomplete, 1);
    }
  }
}

TEST(Decoder, DropsTheScanWholeIfPacketsComeTwiceOrInAnotherOrder) {
  const auto whole = scan_of(devices::xela_xr1944());
  auto twice = whole;
  twice.insert(twice.begin() + 5, whole[4]);
  auto swapped = whole;
  std::swap(swapped[3], swapped[9]);
  for (const auto& bad : {twice, swapped}) {
    DecoderRig rig("xela-xr1944");
    EXPECT_EQ(rig.frames(bad), 0);
    EXPECT_GE(rig.decoder.counts().incomplete, 1);
    EXPECT_EQ(rig.frames(whole), 1);
  }
}

TEST(Decoder, DropsTheScanWholeIfAPacketIsTooShortOrTooLong) {
  const auto whole = scan_of(devices::xela_xr1944());
  for (const std::size_t length : {0U, 6U, 8U}) {
    for (const std::size_t at : {0U, 5U}) {
      DecoderRig rig("xela-xr1944");
      auto bad = whole;
      bad[at].bytes.resize(length);
      EXPECT_EQ(rig.frames(bad), 0);
      EXPECT_EQ(rig.decoder.counts().malformed, 1);
      EXPECT_EQ(rig.frames(whole), 1);
      EXPECT_EQ(rig.out.slot.sequence, 1);
    }
  }
}

TEST(Decoder, TellsHowPacketsThatNoRuleDescribesDiffer) {
  DecoderRig hid("vendor-hid-8x8");
  EXPECT_EQ(hid.decoder.why_no_frames("reports"), "") << "nothing has come";
  const std::vector<std::uint8_t> bytes(64);
  EXPECT_EQ(hid.decoder.take(0, std::span(bytes).first(20), 0, hid.out.slot), Outcome::dropped);
  EXPECT_EQ(hid.decoder.take(0, std::span(bytes).first(20), 0, hid.out.slot), Outcome::dropped)
      << "each counts";
  EXPECT_EQ(hid.decoder.why_no_frames("reports"),
            "reports of 20 bytes arrive, the profile expects 64: choose or correct the profile");
  EXPECT_EQ(hid.decoder.take(9, bytes, 0, hid.out.slot), Outcome::foreign);
  DecoderRig can("icub-mtb");
  EXPECT_EQ(can.decoder.take(1, std::span(bytes).first(8), 0, can.out.slot), Outcome::foreign);
  EXPECT_THAT(can.decoder.why_no_frames("messages"),
              testing::AllOf(testing::HasSubstr("messages of 8 bytes with id 1 arrive, the profile expects "),
                             testing::HasSubstr(" with id ")));
  can.decoder.reset();
  EXPECT_EQ(can.decoder.why_no_frames("messages"), "");
}

TEST(Decoder, NeverMakesOneScanOfTheHalvesOfTwo) {
  DecoderRig rig("xela-xr1944");
  const auto whole = scan_of(devices::xela_xr1944());
  for (std::size_t i = 0; i < 8; ++i) rig.take(whole[i], 0);
  Outcome last = Outcome::partial;
  for (std::size_t i = 8; i < 16; ++i) last = rig.take(whole[i], 10 * kMs);
  EXPECT_NE(last, Outcome::frame);
  EXPECT_EQ(rig.decoder.counts().incomplete, 1);
}

TEST(Decoder, NeverMakesOneScanOfPacketsThatCarryDifferentKeys) {
  DecoderRig rig("vendor-hid-8x8");
  auto packets = scan_of(devices::vendor_hid());
  for (std::size_t i = 4; i < packets.size(); ++i) ++packets[i].bytes[0];
  EXPECT_EQ(rig.frames(packets), 0);
  EXPECT_EQ(rig.decoder.counts().incomplete, 1);
  EXPECT_EQ(rig.frames(scan_of(devices::vendor_hid())), 1);
  EXPECT_EQ(rig.out.slot.sequence, 1);
}

TEST(Decoder, CountsALostPacketAsALostScanIfItWasOrBeganOne) {
  DecoderRig single("robotiq-ft300");
  const auto packet = scan_of(devices::robotiq_ft300());
  EXPECT_EQ(single.frames(packet), 1);
  single.decoder.mark_packet_lost();
  EXPECT_EQ(single.frames(packet), 1);
  EXPECT_EQ(single.out.slot.sequence, 2);

  DecoderRig many("xela-xr1944");
  const auto whole = scan_of(devices::xela_xr1944());
  EXPECT_EQ(many.frames(whole), 1);
  many.decoder.mark_packet_lost();  // it is unknown whether the packet contained all of a scan
  EXPECT_EQ(many.frames(whole), 1);
  EXPECT_EQ(many.out.slot.sequence, 1);
  many.take(whole[0], 0);
  many.decoder.mark_packet_lost();
  EXPECT_EQ(many.decoder.counts().incomplete, 1);
  EXPECT_EQ(many.frames(whole), 1);
  EXPECT_EQ(many.out.slot.sequence, 3);
}

// One packet of one scan, with a count that goes round after 256 and a clock in units of 10 us.
Profile counting() {
  Profile profile = find_profile("robotiq-ft300");
  profile.scan[0].counter = WrappingNumber{6, 1, false, 1};
  profile.scan[0].clock = WrappingNumber{8, 2, true, 10'000};
  return profile;
}

TEST(Decoder, FollowsTheDevicesCountOfScansAndDropsWhatComesTwiceOrLate) {
  const Profile profile = counting();
  Decoder decoder(profile, 0, 0);
  test::OwnedSlot out(1);
  const auto take = [&](std::uint8_t count) {
    return decoder.take(180, Bytes{0, 0, 0, 0, 0, 0, count, 0, 0, 0, 0, 0}, 0, out.slot);
  };
  EXPECT_EQ(take(250), Outcome::frame);
  EXPECT_EQ(out.slot.sequence, 0);
  EXPECT_EQ(take(250), Outcome::dropped) << "twice";
  EXPECT_EQ(take(3), Outcome::frame) << "round it goes";
  EXPECT_EQ(out.slot.sequence, 9);
  EXPECT_EQ(take(2), Outcome::dropped) << "overtaken";
  EXPECT_EQ(take(4), Outcome::frame);
  EXPECT_GT(out.slot.sequence, 9);
  EXPECT_EQ(decoder.counts().repeated, 2);
}

TEST(Decoder, UnrollsTheDevicesClock) {
  const Profile profile = counting();
  Decoder decoder(profile, 0, 0);
  test::OwnedSlot out(1);
  std::uint8_t count = 0;
  const auto time_after = [&](std::uint8_t high, std::uint8_t low) {
    EXPECT_EQ(decoder.take(180, Bytes{0, 0, 0, 0, 0, 0, ++count, 0, high, low, 0, 0}, 0, out.slot),
              Outcome::frame);
    return out.slot.device_time_ns;
  };
  EXPECT_EQ(time_after(0xFF, 0xFF), 655'350'000);
  EXPECT_EQ(time_after(0x00, 0x01), 655'370'000);
  EXPECT_EQ(time_after(0x01, 0x01), 657'930'000);
}

TEST(Decoder, LeavesOtherBoardsOnTheBusAlone) {
  DecoderRig first("xela-xr1944", 0, 1), second("xela-xr1944", 0, 2);
  auto of_second = scan_of(devices::xela_xr1944());
  for (Packet& packet : of_second) packet.address += 0x10;
  auto mixed = scan_of(devices::xela_xr1944());
  for (std::size_t i = 0; i < of_second.size(); ++i)
    mixed.insert(mixed.begin() + static_cast<std::ptrdiff_t>(2 * i), of_second[i]);
  EXPECT_EQ(first.frames(mixed), 1);
  EXPECT_EQ(second.frames(mixed), 1);
  EXPECT_EQ(first.decoder.counts().packets, 16);
}

TEST(Decoder, SurvivesAnyBytesAndGivesFiniteNumbersOnly) {
  std::mt19937 random(7);
  for (const char* name : {"xela-xr1944", "icub-mtb", "onrobot-rg2-ft", "robotiq-ft300", "vendor-hid-8x8"}) {
    DecoderRig rig(name);
    const auto& rules = rig.decoder.rules();
    const std::uint64_t before = test::allocations();
    std::array<std::uint8_t, 80> bytes{};
    std::uint64_t last = 0;
    for (int i = 0; i < 20000; ++i) {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
      const PacketRule& rule =
          rules[random() % 4 == 0 ? random() % rules.size() : static_cast<std::size_t>(i) % rules.size()];
      const std::size_t length = random() % 8 == 0 ? random() % bytes.size() : rule.length;
      if (rig.decoder.take(rule.id, std::span(bytes).first(length), i * kMs / 10, rig.out.slot) !=
          Outcome::frame) {
        continue;
      }
      EXPECT_GE(rig.out.slot.sequence, last);
      last = rig.out.slot.sequence + 1;
      for (const float value : rig.out.slot.normal_pa) ASSERT_TRUE(std::isfinite(value));
    }
    EXPECT_EQ(test::allocations(), before) << "the hot path allocates";
  }
}

TEST(Number, IsReadInEitherOrderAndWithItsSign) {
  const std::uint8_t bytes[] = {0xFF, 0x01, 0x80, 0x3F};
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::natural, 1, false}), 255);
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::whole, 1, false}), -1);
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::natural, 2, true}), 0xFF01);
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::whole, 2, true}), -255);
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::natural, 2, false}), 0x01FF);
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::natural, 4, true}), 0xFF01803FU);
  EXPECT_EQ(wire::read_number(bytes, {NumberKind::whole, 4, true}), -16678849);
  const std::uint8_t one[] = {0x00, 0x00, 0x80, 0x3F};
  EXPECT_EQ(wire::read_number(one, {NumberKind::real, 4, false}), 1);
}

}  // namespace
}  // namespace slipd::decode
