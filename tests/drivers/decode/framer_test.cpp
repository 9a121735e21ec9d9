// Streams of bytes → packets: every complete and valid frame gives its packet once, with any bytes around it
// and in chunks of any size, and nothing else gives a packet.
#include "drivers/decode/framer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "drivers/decode/checksum.hpp"
#include "drivers/decode/csv_line.hpp"
#include "drivers/decode/pts2.hpp"
#include "tests/devices/device_model.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd::decode {
namespace {

using devices::Bytes;
using testing::ElementsAre;
using testing::SizeIs;

Profile profile_with(Stream stream) {
  Profile profile;
  profile.stream = std::move(stream);
  return profile;
}

// AB, length, data …, sum16le over what is between.
Stream by_length() {
  Stream stream;
  stream.begin = {0xAB};
  stream.length_byte = {1, 4};
  stream.longest = 64;
  stream.checksum = {ChecksumKind::sum16le, -2, 1, -2};
  return stream;
}

Bytes frame_of(const Bytes& data) {
  Bytes out{0xAB, static_cast<std::uint8_t>(data.size())};
  devices::append(out, data);
  devices::put_le(out,
                  static_cast<std::uint16_t>(checksum_of(ChecksumKind::sum16le, std::span(out).subspan(1))));
  return out;
}

struct CutPackets {
  std::vector<Bytes> packets;
  int invalid = 0;
};

// `pieces`: how many bytes at a time.
CutPackets cut_into_packets(Framer& framer, const Bytes& bytes, std::size_t pieces = SIZE_MAX) {
  CutPackets cut;
  for (std::size_t at = 0; at < bytes.size(); at += std::min(pieces, bytes.size() - at)) {
    framer.put(std::span(bytes).subspan(at, std::min(pieces, bytes.size() - at)));
    RawPacket packet;
    for (;;) {
      const auto got = framer.next(packet);
      if (got == Framer::Result::incomplete) break;
      if (got == Framer::Result::packet) cut.packets.emplace_back(packet.bytes.begin(), packet.bytes.end());
      cut.invalid += got == Framer::Result::invalid ? 1 : 0;
    }
  }
  return cut;
}

TEST(Framer, CutsTheSamePacketsOutOfPiecesOfAnySize) {
  const Bytes first = frame_of({1, 2, 3}), second = frame_of({}), third = frame_of({0xAB, 0xAB, 2, 9});
  Bytes all = first;
  devices::append(all, second);
  devices::append(all, third);
  for (std::size_t pieces = 1; pieces <= all.size(); ++pieces) {
    Framer framer(profile_with(by_length()));
    const CutPackets cut = cut_into_packets(framer, all, pieces);
    EXPECT_THAT(cut.packets, ElementsAre(first, second, third)) << pieces;
    EXPECT_EQ(cut.invalid, 0);
    EXPECT_EQ(framer.counts().garbage, 0);
  }
}

TEST(Framer, FindsEveryWholeFrameAgainBehindAnyGarbage) {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    Framer framer(profile_with(by_length()));
    Bytes all;
    std::vector<Bytes> sent;
    std::size_t between = 0;
    for (int i = 0; i < 10; ++i) {
      // Bytes that begin no frame of themselves, a frame cut short before one whole: both are lost alone.
      Bytes garbage(random() % 20);
      for (auto& byte : garbage) byte = static_cast<std::uint8_t>(random() % 0xAB);
      devices::append(all, garbage);
      between += garbage.size();
      sent.push_back(frame_of(Bytes(random() % 40, static_cast<std::uint8_t>(random() % 0xAB))));
      devices::append(all, sent.back());
    }
    EXPECT_EQ(cut_into_packets(framer, all, 1 + random() % 30).packets, sent);
    EXPECT_EQ(framer.counts().frames, sent.size());
    EXPECT_EQ(framer.counts().garbage, between);
  }
}

TEST(Framer, LosesTheFrameThatIsDamagedAndNoOther) {
  const Bytes good = frame_of({1, 2, 3, 4});
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const int kind : {0, 1, 2}) {  // a byte changed, missing, or too many
      Bytes bad = good;
      const auto where = bad.begin() + static_cast<std::ptrdiff_t>(at);
      if (kind == 0) *where ^= 0x04;
      if (kind == 1) bad.erase(where);
      if (kind == 2) bad.insert(where, 0x55);
      Bytes all = good;
      devices::append(all, bad);
      for (int i = 0; i < 20; ++i)
        devices::append(all, good);  // a length that grew swallows some bytes of these
      Framer framer(profile_with(by_length()));
      const CutPackets cut = cut_into_packets(framer, all);
      const bool harmless = kind == 2 && at == 0;  // what stands between two frames hurts neither
      EXPECT_THAT(cut.packets, SizeIs(harmless ? 22 : 21)) << at << " " << kind;
      EXPECT_EQ(cut.invalid, 1) << at << " " << kind;
    }
  }
}

TEST(Framer, ReportsEndlessGarbageFromTimeToTime) {
  Framer framer(profile_with(by_length()));
  EXPECT_EQ(cut_into_packets(framer, Bytes(10, 0x11)).invalid, 0) << "one may come in the middle of a frame";
  EXPECT_GE(cut_into_packets(framer, Bytes(640, 0x11), 30).invalid, 5);
  EXPECT_EQ(cut_into_packets(framer, frame_of({1})).packets.size(), 1);
  EXPECT_EQ(cut_into_packets(framer, Bytes(10, 0x11)).invalid, 1);
}

TEST(Framer, LooksForAnEndMarkerNoFurtherThanTheLongestFrame) {
  Stream stream;
  stream.begin = {1, 2};
  stream.end = {3, 4};
  stream.longest = 11;
  for (const std::size_t pieces : {std::size_t{1}, std::size_t{3}, std::size_t{100}}) {
    Framer framer(profile_with(stream));
    const CutPackets cut = cut_into_packets(
        framer, {1, 2, 9, 3, 4, 7, 1, 2, 3, 3, 4, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 3, 4, 1, 2, 3, 4}, pieces);
    EXPECT_THAT(cut.packets, ElementsAre(Bytes{1, 2, 9, 3, 4}, Bytes{1, 2, 3, 3, 4}, Bytes{1, 2, 3, 4}));
    EXPECT_EQ(cut.invalid, 2);
  }
}

TEST(Framer, TakesAFrameOfTheLongestLengthAndNoneLonger) {
  Stream marked;
  marked.begin = {1};
  marked.end = {2};
  marked.longest = 5;
  Stream counted = by_length();
  counted.longest = 9;
  for (const std::size_t more : {0U, 1U}) {
    Bytes frame{1};
    frame.resize(4 + more, 7);
    frame.push_back(2);
    Framer by_marker(profile_with(marked)), by_count(profile_with(counted));
    EXPECT_THAT(cut_into_packets(by_marker, frame).packets, SizeIs(1 - more));
    EXPECT_THAT(cut_into_packets(by_count, frame_of(Bytes(5 + more, 7))).packets, SizeIs(1 - more));
  }
}

TEST(Framer, TakesNoFrameThatItsMarkersDoNotFitInto) {
  Stream stream;
  stream.begin = stream.end = {0xAB};
  stream.length_byte = {1, 1};
  stream.longest = 9;
  Framer framer(profile_with(stream));
  EXPECT_THAT(cut_into_packets(framer, {0xAB, 0, 0x11, 0x11, 0xAB, 1, 0xAB, 2, 0xAB}).packets,
              ElementsAre(Bytes{0xAB, 2, 0xAB}));
}

TEST(Framer, GivesEachRecordItsTagAndDropsWhatFollowsAnUnknownOne) {
  Stream stream = by_length();
  stream.records_from = 2;
  stream.checksum = {};
  stream.length_byte.plus = 2;
  stream.records = {{0x10, 0xF0, 2}, {0x70, 0xFF, 1}};
  Framer framer(profile_with(stream));
  framer.put(Bytes{0xAB, 8, 0x14, 1, 2, 0x70, 3, 0x55, 0x10, 0});
  RawPacket packet;
  ASSERT_EQ(framer.next(packet), Framer::Result::packet);
  EXPECT_EQ(packet.id, 0x14);
  EXPECT_THAT(packet.bytes, ElementsAre(1, 2));
  ASSERT_EQ(framer.next(packet), Framer::Result::packet);
  EXPECT_EQ(packet.id, 0x70);
  EXPECT_EQ(framer.next(packet), Framer::Result::invalid);
  EXPECT_EQ(framer.next(packet), Framer::Result::incomplete);
}

TEST(Framer, PassesPiecesOnAsPacketsWhereThereIsNoStream) {
  Framer framer{Profile{}};
  EXPECT_THAT(cut_into_packets(framer, {1, 2, 3}, 2).packets, ElementsAre(Bytes{1, 2}, Bytes{3}));
}

TEST(Framer, SurvivesAnyBytesWithoutTheHeap) {
  std::mt19937 random(11);
  for (const char* name : {"contactile-pts2", "robotiq-tsf85"}) {
    const Profile profile = find_profile(name);
    Framer framer(profile);
    const Bytes begin = profile.stream->begin, end = profile.stream->end;
    Bytes piece(200);
    const std::uint64_t before = test::allocations();
    for (int i = 0; i < 20000; ++i) {
      for (auto& byte : piece) byte = static_cast<std::uint8_t>(random() % 8 == 0 ? 0 : random());
      std::ranges::copy(begin, piece.begin() + static_cast<std::ptrdiff_t>(random() % 150));
      std::ranges::copy(end, piece.begin() + static_cast<std::ptrdiff_t>(random() % 150));
      framer.put(std::span(piece).first(random() % piece.size()));
      RawPacket packet;
      while (framer.next(packet) != Framer::Result::incomplete) ASSERT_LE(packet.bytes.size(), 4096);
    }
    EXPECT_EQ(test::allocations(), before);
    EXPECT_GT(framer.counts().invalid, 500);
  }
}

TEST(Checksum, OfKnownBytesIsTheKnownOne) {
  const Bytes digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(checksum_of(ChecksumKind::crc8, digits), 0xF4) << "the check value of CRC-8/SMBUS";
  EXPECT_EQ(checksum_of(ChecksumKind::sum16le, digits), 477);
}

// Two sensors of which the second has no block: W = 1, table, blocks.
Bytes pts2(std::uint8_t sensors) {
  Bytes in{1, 1, 0, 9, 3, 0, 21, 0, 0};
  for (std::uint8_t i = 0; i < 12; ++i) in.push_back(i);
  in.push_back(sensors);
  const auto pillars = static_cast<std::uint8_t>(22 + sensors);
  for (std::uint8_t i = 0; i < sensors; ++i) in.push_back(pillars);  // all speak of the same
  in.push_back(1);
  in.push_back(static_cast<std::uint8_t>(pillars + 2));
  devices::put_le(in, std::uint16_t{2});
  for (int i = 0; i < 6; ++i) devices::put_le(in, static_cast<float>(i));
  return in;
}

TEST(Pts2, PutsWhatStandsBehindOffsetsOfAnyWidthIntoFixedPlaces) {
  Bytes out(kPts2Head + 2 * kPts2Pillar);
  ASSERT_TRUE(flatten_pts2(pts2(1), 2, 1, out));
  EXPECT_EQ(Bytes(out.begin(), out.begin() + 12), (Bytes{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}));
  float force_z = 0, absent = 0;
  std::memcpy(&force_z, out.data() + kPts2Head + 8, sizeof force_z);
  std::memcpy(&absent, out.data() + kPts2Head + kPts2Pillar, sizeof absent);
  EXPECT_EQ(force_z, 2);
  EXPECT_TRUE(std::isnan(absent)) << "a sensor that is not plugged in measures nothing";
  EXPECT_FALSE(flatten_pts2(pts2(1), 2, 9, out)) << "another kind of sensor";
}

TEST(Pts2, ComesOutOfAStreamWithoutAChecksum) {
  Stream stream;
  stream.begin = {0xAB};
  stream.length = stream.longest = 1 + pts2(1).size();
  stream.pts2 = true;
  Profile profile = profile_with(stream);
  profile.sensors = 1;
  profile.layout = TaxelLayout::grid(1, 1, 1e-3);
  Bytes frame = stream.begin;
  devices::append(frame, pts2(1));
  Framer framer(profile);
  EXPECT_THAT(cut_into_packets(framer, frame).packets, ElementsAre(SizeIs(kPts2Head + kPts2Pillar)));
}

TEST(Pts2, RefusesASensorOfMorePillarsThanAskedFor) {
  Bytes two = pts2(1);
  two[23] = 2;
  two[24] = 26;
  two.insert(two.begin() + 25, 26);  // both are the same
  Bytes out(kPts2Head + 2 * kPts2Pillar);
  EXPECT_TRUE(flatten_pts2(two, 1, 2, out));
  EXPECT_FALSE(flatten_pts2(two, 1, 1, out));
}

TEST(Pts2, PassesOverABlockOfAnotherTypeUnlessItWouldLieBehindTheEnd) {
  Bytes in = pts2(1);
  for (const std::size_t offset : {3U, 6U, 22U, 24U}) in[offset] += 3;
  in.insert(in.begin() + 7, {7, 0, 30});
  Bytes out(kPts2Head + kPts2Pillar);
  EXPECT_TRUE(flatten_pts2(in, 1, 1, out));
  in[9] = static_cast<std::uint8_t>(in.size() - 1);
  EXPECT_TRUE(flatten_pts2(in, 1, 1, out));
  in[9] = static_cast<std::uint8_t>(in.size());
  EXPECT_FALSE(flatten_pts2(in, 1, 1, out));
}

TEST(Pts2, RefusesOffsetsThatLeadAnywhereElse) {
  Bytes out(kPts2Head + 2 * kPts2Pillar);
  const Bytes good = pts2(2);
  ASSERT_TRUE(flatten_pts2(good, 2, 1, out));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(flatten_pts2(std::span(good).first(size), 2, 1, out)) << size;
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (int value = 0; value < 256; ++value) {
      Bytes bad = good;
      bad[at] = static_cast<std::uint8_t>(value);
      static_cast<void>(flatten_pts2(bad, 2, 1, out));  // the sanitizers see what it reads
    }
  }
}

// Eight bytes, the last two of them an end marker, and no begin marker.
Stream by_end() {
  Stream stream;
  stream.end = {13, 10};
  stream.length = stream.longest = 8;
  return stream;
}

TEST(FramesWithoutABeginMarker, AreFoundAgainAfterAPartOfOneAndMayHoldTheEndMarker) {
  const Profile profile = profile_with(by_end());
  Framer framer(profile);
  const Bytes in{9, 13, 10, 1, 13, 10, 4, 5, 6, 13, 10, 7, 7, 7, 7, 7, 7, 13, 10};
  framer.put(in);
  std::vector<Bytes> packets;
  RawPacket packet;
  for (auto got = framer.next(packet); got != Framer::Result::incomplete; got = framer.next(packet))
    if (got == Framer::Result::packet) packets.emplace_back(packet.bytes.begin(), packet.bytes.end());
  EXPECT_THAT(packets, ElementsAre(Bytes{1, 13, 10, 4, 5, 6, 13, 10}, Bytes{7, 7, 7, 7, 7, 7, 13, 10}));
}

Bytes text(const std::string& line) {
  return {line.begin(), line.end()};
}

// Lines, and nothing where they begin.
Stream by_line() {
  Stream stream;
  stream.end = {13, 10};
  stream.longest = 32;
  return stream;
}

TEST(FramesOfOnlyAnEndMarker, AreReadFromBehindTheFirstOneAfterEachOpening) {
  for (const std::size_t pieces : {std::size_t{1}, std::size_t{5}, std::size_t{100}}) {
    Framer framer(profile_with(by_line()));
    for (int opening = 0; opening < 2; ++opening) {
      const CutPackets cut = cut_into_packets(framer, text("2.5,-0.2,31.25\r\n1,2,3\r\n4,5,6\r\n7,"), pieces);
      EXPECT_THAT(cut.packets, ElementsAre(text("1,2,3\r\n"), text("4,5,6\r\n"))) << pieces;
      EXPECT_EQ(cut.invalid, 0) << "no frame was lost";
      framer.reset();
    }
    EXPECT_EQ(framer.counts().garbage, 2 * text("2.5,-0.2,31.25\r\n").size());
  }
}

TEST(FramesOfOnlyAnEndMarker, AreReportedMissingWhereItNeverComes) {
  Framer framer(profile_with(by_line()));
  EXPECT_EQ(cut_into_packets(framer, Bytes(32, '1')).invalid, 0);
  const CutPackets cut = cut_into_packets(framer, Bytes(320, '1'), 10);
  EXPECT_GE(cut.invalid, 5);
  EXPECT_THAT(cut.packets, ElementsAre());
}

std::vector<double> numbers_of(const std::string& line, std::size_t values) {
  Bytes to(8 * values);
  const Bytes from = text(line);
  if (!numbers_of_line(from, to)) return {};
  std::vector<double> out(values);
  std::memcpy(out.data(), to.data(), to.size());
  return out;
}

TEST(LinesOfNumbers, AreReadWithAnySeparatorAndRefusedWithAnotherCount) {
  for (const char* line : {"1.5,-2,3e-1", "1.5; -2; 3e-1\r", " 1.5 -2\t0.3 ", "+1.5,-2,+.3"})
    EXPECT_THAT(numbers_of(line, 3), ElementsAre(1.5, -2, 0.3)) << line;
  for (const char* line : {"", "1.5,-2", "1.5,-2,3,4", "1.5,,-2", "a,b,c", "1.5-2-3", "1,2,3x", "1,2,"})
    EXPECT_THAT(numbers_of(line, 3), ElementsAre()) << line;
}

// Check values of the catalogues of CRCs, and by hand.
TEST(Checksums, AreThoseOfTheirStandards) {
  const Bytes nine = text("123456789");
  EXPECT_EQ(checksum_of(ChecksumKind::crc8, nine), 0xF4U);
  EXPECT_EQ(checksum_of(ChecksumKind::crc16modbus, nine), 0x4B37U);
  EXPECT_EQ(checksum_of(ChecksumKind::crc16xmodem, nine), 0x31C3U);
  EXPECT_EQ(checksum_of(ChecksumKind::sum8, nine), 0xDDU);
  EXPECT_EQ(checksum_of(ChecksumKind::lrc8, nine), 0x23U);
  EXPECT_EQ(checksum_of(ChecksumKind::xor8, nine), 0x31U);
}

}  // namespace
}  // namespace slipd::decode
