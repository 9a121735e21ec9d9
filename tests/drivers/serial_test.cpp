// The serial driver and devices at the other end of a pseudo-terminal: one that sends by itself, one that
// prints lines, one that answers requests, one whose packets end by silence.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/storage/unique_fd.hpp"
#include "drivers/pacing.hpp"
#include "drivers/serial/serial_driver.hpp"
#include "drivers/serial/serial_transport.hpp"
#include "tests/devices/bytes.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/patience.hpp"

namespace slipd::serial {
namespace {

using namespace std::chrono_literals;
using devices::Bytes;
using ::testing::Each;
using ::testing::FloatEq;
using ::testing::HasSubstr;

// The device's end of a line, and the path of the host's.
class Line {
 public:
  Line() {
    int master = -1, host = -1;
    char name[64];
    termios raw{};
    ::cfmakeraw(&raw);
    EXPECT_EQ(::openpty(&master, &host, name, &raw, nullptr), 0);
    master_ = UniqueFd(master);
    host_ = UniqueFd(host);
    path = name;
  }
  void say(const Bytes& bytes) const {
    EXPECT_EQ(::write(master_.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void say(const std::string& text) const { say(Bytes(text.begin(), text.end())); }
  // Waits for so many bytes of the host.
  Bytes hear(std::size_t count) const {
    Bytes heard(count);
    std::size_t at = 0;
    while (at < count) {
      const ssize_t got = ::read(master_.get(), heard.data() + at, count - at);
      if (got <= 0) break;
      at += static_cast<std::size_t>(got);
    }
    heard.resize(at);
    return heard;
  }
  void cut() {
    host_ = UniqueFd();
    master_ = UniqueFd();
  }

  std::string path;

 private:
  UniqueFd master_, host_;
};

SensorSetup on(const Line& line, const std::string& profile) {
  SensorSetup setup = test::setup_of(TaxelLayout::wrench(0.01), {{"sensor", 0}});
  setup.profile = profile;
  setup.device = {{"path", line.path}};
  return setup;
}

// A driver with its slot, read until something is seen.
class Host {
 public:
  Host(const Line& line, const std::string& profile, std::size_t taxels)
      : driver({on(line, profile)}), owned_(taxels), slots(1, owned_.slot) {
    driver.open();
  }
  bool sees(ReadStatus wanted) {
    const auto give_up = std::chrono::steady_clock::now() + testing::kPatience;
    while (std::chrono::steady_clock::now() < give_up)
      if (driver.read(slots, 20ms).status == wanted) return true;
    return false;
  }

  SerialDriver driver;

 private:
  test::OwnedSlot owned_;

 public:
  std::vector<FrameSlot> slots;
};

// Chip k has x = 10 k + 1, y = 10 k + 2, z = 10 k + 3.
Bytes anyskin_frame() {
  Bytes out;
  for (int chip = 0; chip < 5; ++chip) {
    devices::put_le(out, 25.0F);
    for (int axis = 1; axis <= 3; ++axis) devices::put_le(out, static_cast<float>(10 * chip + axis));
  }
  devices::append(out, {'\r', '\n'});
  return out;
}

TEST(SerialDriver, ReadsADeviceThatTalksBeforeItIsAskedFromTheMiddleOfAFrameOn) {
  Line line;
  Host host(line, "anyskin", 5);
  Bytes half = anyskin_frame();
  half.erase(half.begin(), half.begin() + 33);
  line.say(half);
  line.say(anyskin_frame());
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  EXPECT_THAT(host.slots[0].normal_pa, ::testing::ElementsAre(3, 13, 23, 33, 43));
  EXPECT_THAT(host.slots[0].shear_x_pa, ::testing::ElementsAre(2, 12, -21, -32, 41));
  EXPECT_THAT(host.slots[0].shear_y_pa, ::testing::ElementsAre(1, 11, 22, -31, -42));
}

TEST(SerialDriver, SaysThatMagnetometersAreNoPressures) {
  Line line;
  SerialDriver driver({on(line, "anyskin")});
  EXPECT_FALSE(driver.open().sensors.at(0).calibrated);
}

// A row of a recording, ten chips of x, y, z, as the board had sent it.
Bytes eflesh_frame(const std::vector<float>& row) {
  Bytes out;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i % 3 == 0) devices::put_le(out, 25.0F);
    devices::put_le(out, row[i]);
  }
  devices::append(out, {'\r', '\n'});
  return out;
}

TEST(SerialDriver, ReadsARecordingOfTwoPadsOnOneBoardValueByValue) {
  Line line;
  std::vector<SensorSetup> setups(2, on(line, "eflesh"));
  setups[1].options["sensor"] = 1;
  SerialDriver driver(setups);
  EXPECT_FALSE(driver.open().sensors.at(0).calibrated);
  test::OwnedSlot left(5), right(5);
  std::vector<FrameSlot> slots{left.slot, right.slot};
  std::ifstream recording(SLIPD_SOURCE_DIR "/tests/data/eflesh/seq_000.csv");
  std::string text;
  std::getline(recording, text);
  int rows = 0;
  while (std::getline(recording, text)) {
    std::vector<float> row;
    std::istringstream in(text);
    for (std::string value; std::getline(in, value, ',');) row.push_back(std::stof(value));
    ASSERT_EQ(row.size(), 30U);
    line.say(eflesh_frame(row));
    const auto give_up = std::chrono::steady_clock::now() + testing::kPatience;
    std::set<std::uint16_t> seen;
    while (seen.size() < 2 && std::chrono::steady_clock::now() < give_up) {
      const ReadResult read = driver.read(slots, 20ms);
      if (read.status == ReadStatus::frame) seen.insert(read.sensor);
    }
    ASSERT_EQ(seen.size(), 2U);
    for (std::size_t i = 0; i < 10; ++i) {
      const FrameSlot& slot = slots[i / 5];
      EXPECT_EQ(slot.shear_x_pa[i % 5], row[3 * i]);
      EXPECT_EQ(slot.shear_y_pa[i % 5], row[3 * i + 1]);
      EXPECT_EQ(slot.normal_pa[i % 5], row[3 * i + 2]);
    }
    ++rows;
  }
  EXPECT_EQ(rows, 300);
}

TEST(SerialDriver, ReadsLinesOfNumbersAndDropsBrokenOnes) {
  Line line;
  Host host(line, "csv-force", 1);
  line.say("25\n7.5\n0.5, -0.25, 2\r\n");
  ASSERT_TRUE(host.sees(ReadStatus::corrupt));
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  const double area_m2 = 0.01 * 0.01;
  EXPECT_THAT(host.slots[0].normal_pa, Each(FloatEq(static_cast<float>(2 / area_m2))));
  EXPECT_THAT(host.slots[0].shear_x_pa, Each(FloatEq(static_cast<float>(0.5 / area_m2))));
  EXPECT_THAT(host.slots[0].shear_y_pa, Each(FloatEq(static_cast<float>(-0.25 / area_m2))));
}

TEST(SerialDriver, ReadsNoForceOutOfTheRestOfALineAtItsOpening) {
  Line line;
  Host host(line, "csv-force", 1);
  line.say("2.5,-0.2,31.25\n1,2,3\n");  // of "12.5,-0.2,31.25"
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  EXPECT_THAT(host.slots[0].normal_pa, Each(FloatEq(static_cast<float>(3 / (0.01 * 0.01)))));
}

TEST(SerialDriver, SeesThatTheLineIsGoneAndReadsAnotherOne) {
  Line line;
  Host host(line, "csv-force", 1);
  line.say("3\n1,2,3\n");
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  line.cut();
  EXPECT_TRUE(host.sees(ReadStatus::disconnected));
  host.driver.close();
  EXPECT_THAT(test::refusal_of([&] { host.driver.open(); }), HasSubstr("there is no such serial line"));
}

TEST(SerialDriver, IsTheOnlyOneOnItsLine) {
  Line line;
  Host host(line, "csv-force", 1);
  SerialDriver second({on(line, "csv-force")});
  EXPECT_THAT(test::refusal_of([&] { second.open(); }), HasSubstr("another program has it open"));
}

TEST(SerialDriver, RefusesWhatIsNoSerialLineAndADeviceWithoutAPath) {
  Line line;
  SensorSetup file = on(line, "csv-force");
  file.device = {{"path", "/dev/null"}};
  SerialDriver driver({file});
  EXPECT_THAT(test::refusal_of([&] { driver.open(); }), HasSubstr("is no serial line"));
  file.device = {{"serial", "A1"}};
  EXPECT_THAT(test::refusal_of([&] { SerialDriver({file}); }), HasSubstr("expected {\"path\""));
}

// What another baud rate makes of a device's bytes.
TEST(SerialDriver, TellsThatTheBaudRateMayBeWrongWhereBytesMakeNoPacket) {
  Line line;
  Host host(line, "paxini-l5325", 120);
  line.say(Bytes(900, 0xF8));
  ASSERT_TRUE(host.sees(ReadStatus::corrupt));
  EXPECT_THAT(host.driver.why_no_frames(), HasSubstr("the device has another baud rate"));
  EXPECT_THAT(host.driver.why_no_frames(), HasSubstr("921600 baud"));
}

TEST(SerialDriver, AllocatesNothingWhileItReads) {
  Line line;
  Host host(line, "anyskin", 5);
  line.say(anyskin_frame());
  ASSERT_TRUE(host.sees(ReadStatus::frame));
  line.say(anyskin_frame());
  const auto before = test::allocations();
  EXPECT_TRUE(host.sees(ReadStatus::frame));
  EXPECT_EQ(test::allocations(), before);
}

// A control box with one module: it answers the request of its taxels, and the two that set it up.
class ControlBox {
 public:
  static constexpr std::size_t kSetUp = 17, kRequest = 21;

  static Bytes answer() {
    Bytes out{0x55, 0xAA, 0x7B, 0x7B, 14, 0, 112, 192, 6, 0, 110, 1, 0, 0, 0, 0, 0, 0};
    for (int taxel = 0; taxel < 120; ++taxel)
      devices::append(out, {static_cast<std::uint8_t>(taxel), static_cast<std::uint8_t>(-taxel), 200});
    std::uint8_t sum = 0;
    for (std::size_t i = 4; i < out.size(); ++i) sum = static_cast<std::uint8_t>(sum + out[i]);
    devices::append(out, {static_cast<std::uint8_t>(-sum), 0x55, 0xAA, 0x7D, 0x7D});
    return out;
  }
};

TEST(SerialDriver, AsksADeviceThatOnlyAnswersRoundAfterRound) {
  Line line;
  Host host(line, "paxini-l5325", 120);
  std::jthread box([&] {
    line.hear(2 * ControlBox::kSetUp);
    for (int round = 0; round < 3; ++round) {
      const Bytes request = line.hear(ControlBox::kRequest);
      ASSERT_EQ(request.size(), ControlBox::kRequest);
      EXPECT_EQ(request[8], 6) << "the taxels";
      line.say(ControlBox::answer());
    }
  });
  for (int round = 0; round < 3; ++round) ASSERT_TRUE(host.sees(ReadStatus::frame)) << round;
  for (std::size_t taxel = 0; taxel < 120; ++taxel) {
    EXPECT_EQ(host.slots[0].shear_x_pa[taxel], static_cast<float>(taxel));
    EXPECT_EQ(host.slots[0].shear_y_pa[taxel], -static_cast<float>(taxel));
    EXPECT_EQ(host.slots[0].normal_pa[taxel], 200);
  }
}

TEST(SerialDriver, CountsAnAnswerThatNeverComesAndAsksAgain) {
  Line line;
  Host host(line, "paxini-l5325", 120);
  line.hear(2 * ControlBox::kSetUp);
  EXPECT_TRUE(host.sees(ReadStatus::corrupt));
  EXPECT_THAT(host.driver.why_no_frames(), HasSubstr("answers no request"));
  line.hear(ControlBox::kRequest);
  line.say(ControlBox::answer());
  EXPECT_TRUE(host.sees(ReadStatus::frame));
}

TEST(Poller, LeavesOutTheRestOfARoundAndKeepsToItsRate) {
  constexpr std::int64_t kMs = 1'000'000;
  Poller poller({{{1}, 3 * kMs}, {{2}, 3 * kMs}}, 100);
  ASSERT_NE(poller.due(0), nullptr);
  EXPECT_EQ(poller.due(0)->bytes, Bytes{1});
  poller.sent(0);
  EXPECT_EQ(poller.due(kMs), nullptr) << "one at a time";
  poller.answered();
  ASSERT_NE(poller.due(kMs), nullptr);
  EXPECT_EQ(poller.due(kMs)->bytes, Bytes{2});
  poller.sent(kMs);
  EXPECT_FALSE(poller.expire(3 * kMs));
  EXPECT_TRUE(poller.expire(4 * kMs));
  EXPECT_EQ(poller.due(9 * kMs), nullptr) << "the next round has its time";
  EXPECT_EQ(poller.look_again_ns(), 10 * kMs);
  ASSERT_NE(poller.due(10 * kMs), nullptr);
  EXPECT_EQ(poller.due(10 * kMs)->bytes, Bytes{1});
}

TEST(SerialTransport, EndsAPacketBySilence) {
  Line line;
  decode::Profile profile;
  profile.rate_hz = 100;
  SerialTransport transport(line.path, profile, {.silence_ns = 30'000'000, .poll = {}});
  decode::ReceivedBytes received;
  line.say(Bytes{1, 2});
  EXPECT_EQ(transport.receive(received, monotonic_ns() + 1'000'000), decode::ReceiveResult::timeout)
      << "more may come";
  line.say(Bytes{3});
  const std::int64_t patience_ns = std::chrono::nanoseconds(testing::kPatience).count();
  ASSERT_EQ(transport.receive(received, monotonic_ns() + patience_ns), decode::ReceiveResult::bytes);
  EXPECT_THAT(received.bytes, ::testing::ElementsAre(1, 2, 3));
}

}  // namespace
}  // namespace slipd::serial
