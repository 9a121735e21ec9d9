// HID report descriptors: valid ones are parsed, invalid ones are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "drivers/hid/descriptor.hpp"
#include "tests/devices/device_model.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace slipd::hid {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kForce = 0x00200494;

TEST(Descriptor, SaysWhereAForceStandsAndWhatACountIs) {
  const Bytes& said = devices::hid_force().hid->report_descriptor;
  const auto fields = input_fields(said);
  ASSERT_EQ(fields.size(), 2);
  EXPECT_EQ(fields[1].usage, kForce);
  EXPECT_EQ(fields[1].report, 1);
  EXPECT_EQ(fields[1].bit, 8);
  EXPECT_EQ(fields[1].bits, 32);
  EXPECT_TRUE(fields[1].is_signed);
  EXPECT_NEAR(fields[1].newtons_a_count, 1e-3, 1e-12);
  EXPECT_EQ(report_length(said, 1), 5);
  EXPECT_EQ(report_length(said, 9), 0);
}

TEST(Descriptor, OfASixAxisDeviceHasTwoReports) {
  const Bytes& said = devices::space_mouse().hid->report_descriptor;
  const auto fields = input_fields(said);
  ASSERT_EQ(fields.size(), 6);
  EXPECT_EQ(fields[2].usage, 0x00010032) << "z";
  EXPECT_EQ(fields[2].bit, 32);
  EXPECT_EQ(fields[3].report, 2);
  EXPECT_EQ(fields[3].bit, 0);
}

TEST(Descriptor, ScalesFromLogicalToPhysicalInItsUnit) {
  // u16 0 … 1000 is -5 … 5 N: in dyne, with an exponent of 5.
  const Bytes said{0x05, 0x20, 0x0A, 0x94, 0x04, 0x15, 0x00, 0x26, 0xE8, 0x03, 0x35, 0xFB, 0x45,
                   0x05, 0x66, 0x11, 0xE1, 0x55, 0x05, 0x75, 0x10, 0x95, 0x01, 0x81, 0x02};
  const auto fields = input_fields(said);
  ASSERT_EQ(fields.size(), 1);
  EXPECT_FALSE(fields[0].is_signed);
  EXPECT_NEAR(fields[0].newtons_a_count, 0.01, 1e-12);
  EXPECT_NEAR(fields[0].zero_count, 500, 1e-9);
}

// One force of the bits, with the items that give its ranges.
Bytes force_of_ranges(const Bytes& ranges, std::uint8_t bits) {
  Bytes said{0x05, 0x20, 0x0A, 0x94, 0x04};
  said.insert(said.end(), ranges.begin(), ranges.end());
  said.insert(said.end(), {0x75, bits, 0x95, 0x01, 0x81, 0x02});
  return said;
}

TEST(Descriptor, TakesAMaximumForUnsignedWhereItsMinimumIsNotNegative) {
  const auto scale_of = [](const Bytes& ranges, std::uint8_t bits) {
    return input_fields(force_of_ranges(ranges, bits)).at(0).newtons_a_count;
  };
  EXPECT_NEAR(scale_of({0x15, 0x00, 0x26, 0xFF, 0xFF, 0x35, 0x00, 0x45, 0x0A}, 16), 10.0 / 65535, 1e-12);
  EXPECT_NEAR(scale_of({0x15, 0x00, 0x26, 0xFF, 0x00, 0x35, 0x00, 0x45, 0xC8}, 8), 200.0 / 255, 1e-12);
  EXPECT_NEAR(scale_of({0x15, 0x00, 0x27, 0xFF, 0xFF, 0xFF, 0xFF, 0x35, 0x00, 0x45, 0x0A}, 32),
              10.0 / 4294967295, 1e-15);
  EXPECT_NEAR(scale_of({0x15, 0x81, 0x25, 0x7F, 0x35, 0x81, 0x45, 0xFF}, 8), 126.0 / 254, 1e-12)
      << "-127 to -1, as its minimum is negative";
}

TEST(Descriptor, WhoseRangeDoesNotRiseGivesNoForce) {
  const auto said_of = [](const Bytes& ranges) {
    decode::Profile profile = decode::find_profile("hid-force");
    return test::refusal_of([&] { resolve_usages(profile, force_of_ranges(ranges, 16)); });
  };
  EXPECT_EQ(said_of({0x15, 0x00, 0x25, 0x64}), "") << "without a physical range the counts are newtons";
  EXPECT_THAT(said_of({0x15, 0x05, 0x25, 0x05}),
              HasSubstr("usage 0x00200494 in the device's report descriptor has counts from 5 to 5"));
  EXPECT_THAT(said_of({0x15, 0xFF, 0x25, 0xFE}), HasSubstr("counts from -1 to -2"));
  EXPECT_THAT(said_of({0x15, 0x00, 0x25, 0x64, 0x35, 0x0A, 0x45, 0x05}),
              HasSubstr("a physical range from 10 to 5, whose maximum is not above its minimum"));
}

TEST(Descriptor, PutsPlacesIntoAProfileThatNamesUsages) {
  decode::Profile profile = decode::find_profile("hid-force");
  resolve_usages(profile, devices::hid_force().hid->report_descriptor);
  const decode::PacketRule& rule = profile.scan[0];
  EXPECT_EQ(rule.id, 1);
  EXPECT_EQ(rule.length, 5);
  EXPECT_EQ(rule.fields[0].offset, 1);
  EXPECT_EQ(rule.fields[0].type, (decode::NumberType{decode::NumberKind::whole, 4, false}));
  EXPECT_NEAR(rule.fields[0].gain_pa, 1e-3 / 1e-4, 1e-9);

  EXPECT_THAT(
      test::refusal_of([&] { resolve_usages(profile, devices::space_mouse().hid->report_descriptor); }),
      HasSubstr("no input of usage 0x00200494"));
  const Bytes nibble{0x05, 0x20, 0x0A, 0x94, 0x04, 0x75, 0x04, 0x95, 0x01, 0x81, 0x02};
  EXPECT_THAT(test::refusal_of([&] { resolve_usages(profile, nibble); }), HasSubstr("has 4 bits from bit 0"));
}

// Two forces of u16: 0x0495 at byte 60 of report 1, 0x0496 at the beginning of report 2, which has 2 bytes.
Bytes two_reports() {
  return {0x05, 0x20, 0x15, 0x00, 0x26, 0xE8, 0x03,              // 0 to 1000
          0x85, 0x01, 0x75, 0x08, 0x95, 0x3C, 0x81, 0x01,        // padding
          0x0A, 0x95, 0x04, 0x75, 0x10, 0x95, 0x01, 0x81, 0x02,  //
          0x85, 0x02, 0x0A, 0x96, 0x04, 0x81, 0x02};
}

decode::Field byte_at(std::size_t offset) {
  decode::Field field;
  field.taxel = 1;
  field.offset = offset;
  return field;
}

// What is said of a packet whose only field is of a usage in report 2, after `change`.
std::string said_of_packet(const std::function<void(decode::Profile&, decode::PacketRule&)>& change) {
  decode::Profile profile = decode::find_profile("hid-force");
  profile.scan[0].fields[0].usage = 0x00200496;
  change(profile, profile.scan[0]);
  return test::refusal_of([&] { resolve_usages(profile, two_reports()); });
}

TEST(Descriptor, WhoseReportsShareAPacketIsRefused) {
  EXPECT_THAT(said_of_packet([](decode::Profile&, decode::PacketRule& rule) {
                rule.fields.push_back(rule.fields[0]);
                rule.fields[0].usage = 0x00200495;
              }),
              HasSubstr("/scan/packets/0 has usages 0x00200495 and 0x00200496, which are in the device's "
                        "reports 1 and 2: give each report a packet of its own"));
}

TEST(Descriptor, WhoseReportIsShorterThanAPacketOfTheProfileIsRefused) {
  EXPECT_EQ(said_of_packet([](decode::Profile&, decode::PacketRule&) {}), "");
  const std::string all = "Report 2 has 2 bytes by the device's report descriptor";
  EXPECT_THAT(said_of_packet([](decode::Profile&, decode::PacketRule& rule) {
                rule.length = 10;
                rule.fields.push_back(byte_at(8));
              }),
              AllOf(HasSubstr("/scan/packets/0/fields = 8: is a byte behind"), HasSubstr(all)));
  EXPECT_THAT(said_of_packet([](decode::Profile&, decode::PacketRule& rule) {
                rule.counter = decode::WrappingNumber{.offset = 1, .bytes = 2};
              }),
              AllOf(HasSubstr("clock or counter"), HasSubstr(all)));
  EXPECT_THAT(said_of_packet([](decode::Profile&, decode::PacketRule& rule) {
                rule.clock = decode::WrappingNumber{.offset = 4095, .bytes = 1};
              }),
              AllOf(HasSubstr("clock or counter"), HasSubstr(all)));
  EXPECT_THAT(said_of_packet([](decode::Profile&, decode::PacketRule& rule) {
                rule.match = {.offset = 2, .mask = 255, .value = 1};
              }),
              AllOf(HasSubstr("/match/offset = 2: lies behind"), HasSubstr(all)));
  EXPECT_THAT(said_of_packet([](decode::Profile& profile, decode::PacketRule&) { profile.key_offset = 2; }),
              AllOf(HasSubstr("/scan/key_offset = 2: lies behind"), HasSubstr(all)));
}

TEST(Descriptor, OfAnyBytesDoesNotCrash) {
  std::mt19937 random(5);
  const Bytes& good = devices::hid_force().hid->report_descriptor;
  for (int i = 0; i < 20000; ++i) {
    Bytes bad = good;
    for (int changes = 0; changes < 4; ++changes)
      bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    bad.resize(random() % (bad.size() + 1));
    for (const InputField& field : input_fields(bad)) ASSERT_LE(field.bit + field.bits, 4096 * 8);
  }
}

TEST(Descriptor, OfFewBytesCannotClaimFieldsWithoutEnd) {
  Bytes greedy{0x95, 0x7F, 0x96, 0xFF, 0x7F, 0x75, 0x00};  // 32767 values of no bits
  for (int i = 0; i < 1000; ++i) greedy.insert(greedy.end(), {0x09, 0x01, 0x81, 0x02});
  EXPECT_LE(input_fields(greedy).size(), 4096);
}

}  // namespace
}  // namespace slipd::hid
