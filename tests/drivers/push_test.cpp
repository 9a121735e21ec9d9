// The driver push against a program at the other end of its socket: what agrees and what contradicts, whose
// turn it is, and which messages are frames. The driver is read in the test's own thread.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <utility>

#include "drivers/pacing.hpp"
#include "drivers/push/push_driver.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/push_writer.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using push_layout::Answer;
using push_layout::Hello;
using push_layout::Unit;
using push_layout::Zero;
using ::testing::HasSubstr;
using testing::PushWriter;

constexpr std::size_t kPushedTaxels = 4;
constexpr double kPitchM = 0.002;
constexpr double kAreaM2 = kPitchM * kPitchM;

class Push : public ::testing::Test {
 protected:
  // A driver with these options, open. Samples may be old: a machine that does much else is slow.
  DeviceInfo open(json options = json::object(), double rate_hz = 100) {
    options.emplace("path", path_.string());
    options.emplace("max_age_ms", 10'000);
    driver_.reset();
    driver_.emplace(std::vector{setup_of(TaxelLayout::grid(2, 2, kPitchM), std::move(options), rate_hz)});
    return driver_->open();
  }

  ReadResult read(std::chrono::microseconds timeout = 20ms) { return driver_->read(slots_, timeout); }

  // Reads until this status comes, or the program hangs.
  bool reads(ReadStatus wanted) {
    const auto give_up = std::chrono::steady_clock::now() + testing::kPatience;
    while (std::chrono::steady_clock::now() < give_up) {
      if (read().status == wanted) return true;
    }
    return false;
  }

  // What a program with this hello is told.
  PushWriter::Answer answer_to(const Hello& hello) {
    PushWriter writer(path_);
    writer.hello(hello);
    read();
    return writer.answer(MSG_DONTWAIT);
  }

  // A program that the driver has accepted.
  PushWriter accepted(const Hello& hello = {.unit = Unit::pascal, .taxels = kPushedTaxels}) {
    PushWriter writer(path_);
    writer.hello(hello);
    read();
    EXPECT_EQ(writer.answer(MSG_DONTWAIT).code, Answer::accepted);
    return writer;
  }

  // Reads once, what a message with this head and these values becomes.
  ReadStatus becomes(PushWriter& writer, const push_layout::FrameHead& head,
                     const std::vector<float>& values) {
    writer.push(values, head);
    return read().status;
  }

  const std::vector<float> values_{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  testing::TempFolder folder_;
  std::filesystem::path path_ = folder_.file("left");
  std::optional<push::PushDriver> driver_;
  OwnedSlot owned_{kPushedTaxels};
  std::vector<FrameSlot> slots_{owned_.slot};
};

TEST_F(Push, GivesPressuresAndShearsOfEachTaxelInPascal) {
  open();
  PushWriter writer = accepted({.unit = Unit::newton, .taxels = kPushedTaxels});
  const std::int64_t sampled_ns = monotonic_ns();
  ASSERT_EQ(becomes(writer, {.sequence = 7, .time_ns = sampled_ns}, values_), ReadStatus::frame);
  for (std::size_t i = 0; i < kPushedTaxels; ++i) {
    EXPECT_FLOAT_EQ(owned_.slot.shear_x_pa[i], static_cast<float>(values_[3 * i] / kAreaM2));
    EXPECT_FLOAT_EQ(owned_.slot.shear_y_pa[i], static_cast<float>(values_[3 * i + 1] / kAreaM2));
    EXPECT_FLOAT_EQ(owned_.slot.normal_pa[i], static_cast<float>(values_[3 * i + 2] / kAreaM2));
  }
  EXPECT_EQ(slots_[0].time_ns, sampled_ns);
}

TEST_F(Push, ScalesEachAxisByTheConfiguredFactors) {
  open({{"scale", {2, -3, 0.5}}});
  PushWriter writer = accepted({.unit = Unit::counts, .taxels = kPushedTaxels});
  ASSERT_EQ(becomes(writer, {.sequence = 1}, values_), ReadStatus::frame);
  EXPECT_FLOAT_EQ(owned_.slot.shear_x_pa[1], 8);
  EXPECT_FLOAT_EQ(owned_.slot.shear_y_pa[1], -15);
  EXPECT_FLOAT_EQ(owned_.slot.normal_pa[1], 3);
}

TEST_F(Push, TakesAFrameWithoutATimeForOneOfNow) {
  open();
  PushWriter writer = accepted();
  const std::int64_t before_ns = monotonic_ns();
  ASSERT_EQ(becomes(writer, {.sequence = 1}, values_), ReadStatus::frame);
  EXPECT_GE(slots_[0].time_ns, before_ns);
  EXPECT_LE(slots_[0].time_ns, monotonic_ns());
}

TEST_F(Push, OfFramesWithoutATimeThatWaitOnlyTheLastIsOfNow) {
  open();
  PushWriter writer = accepted();
  for (std::uint64_t i = 1; i <= 3; ++i) writer.push(values_, {.sequence = i});
  EXPECT_EQ(read().status, ReadStatus::corrupt);
  EXPECT_EQ(read().status, ReadStatus::corrupt);
  EXPECT_EQ(read().status, ReadStatus::frame);
}

TEST_F(Push, CountsWhatTheProgramHasSkippedAndGoesOnCountingForTheNextProgram) {
  open();
  {
    PushWriter first = accepted();
    becomes(first, {.sequence = 1000}, values_);
    const std::uint64_t before = slots_[0].sequence;
    ASSERT_EQ(becomes(first, {.sequence = 1005}, values_), ReadStatus::frame);
    EXPECT_EQ(slots_[0].sequence, before + 5);
  }
  const std::uint64_t last = slots_[0].sequence;
  PushWriter second = accepted();
  ASSERT_EQ(becomes(second, {.sequence = 1}, values_), ReadStatus::frame);
  EXPECT_EQ(slots_[0].sequence, last + 1);
}

TEST_F(Push, CountsEachMessageThatIsNoFrameAndReadsOn) {
  open();
  PushWriter writer = accepted();
  const std::int64_t begun_ns = monotonic_ns();
  ASSERT_EQ(becomes(writer, {.sequence = 10, .time_ns = begun_ns}, values_), ReadStatus::frame);
  std::vector<float> odd = values_;
  const auto with = [&](float value) {
    odd[5] = value;
    return odd;
  };
  const std::int64_t minute_ns = 60'000'000'000;
  const struct {
    const char* what;
    push_layout::FrameHead head;
    std::vector<float> values;
  } kMessages[] = {{"a sequence that was there", {.sequence = 10}, values_},
                   {"a sequence before the last", {.sequence = 9}, values_},
                   {"another version", {.version = 2, .sequence = 11}, values_},
                   {"a flag of the future", {.flags = 2, .sequence = 11}, values_},
                   {"marked as bad", {.flags = push_layout::kBad, .sequence = 11}, values_},
                   {"a size that is not its own", {.size = 71, .sequence = 11}, values_},
                   {"too few values", {.sequence = 11}, {1, 2, 3}},
                   {"too many values", {.sequence = 11}, std::vector<float>(15)},
                   {"far too many values", {.sequence = 11}, std::vector<float>(10'000)},
                   {"a sample of the future", {.sequence = 11, .time_ns = begun_ns + minute_ns}, values_},
                   {"a sample before the last", {.sequence = 11, .time_ns = begun_ns - 1}, values_},
                   {"a time before all time", {.sequence = 11, .time_ns = -1}, values_},
                   {"not a number", {.sequence = 11}, with(std::numeric_limits<float>::quiet_NaN())},
                   {"infinite", {.sequence = 11}, with(-std::numeric_limits<float>::infinity())}};
  for (const auto& message : kMessages)
    EXPECT_EQ(becomes(writer, message.head, message.values), ReadStatus::corrupt) << message.what;
  EXPECT_EQ(becomes(writer, {.sequence = 11}, values_), ReadStatus::frame);
}

TEST_F(Push, CountsASampleThatIsOlderThanAllowed) {
  open();
  PushWriter writer = accepted();
  const std::int64_t allowed_ns = 10'000'000'000;
  EXPECT_EQ(becomes(writer, {.sequence = 1, .time_ns = monotonic_ns() - allowed_ns - 1}, values_),
            ReadStatus::corrupt);
  EXPECT_EQ(becomes(writer, {.sequence = 2, .time_ns = monotonic_ns()}, values_), ReadStatus::frame);
}

TEST_F(Push, CountsAForceThatIsTooLargeForPascal) {
  open();
  PushWriter writer = accepted({.unit = Unit::newton, .taxels = kPushedTaxels});
  std::vector<float> large = values_;
  large[0] = std::numeric_limits<float>::max();
  EXPECT_EQ(becomes(writer, {.sequence = 1}, large), ReadStatus::corrupt);
}

TEST_F(Push, RefusesAHelloThatContradictsTheConfigurationAndSaysInWhat) {
  open({{"unit", "N"}, {"axes", 3}, {"zeroed", true}});
  const Hello good{.taxels = kPushedTaxels};
  const auto refusal = [&](auto change) {
    Hello hello = good;
    change(hello);
    const auto answer = answer_to(hello);
    EXPECT_EQ(answer.code, Answer::refused);
    return answer.text;
  };
  EXPECT_THAT(refusal([](Hello& h) { h.taxels = 9; }),
              HasSubstr("9 taxels, the layout in the configuration has 4"));
  EXPECT_THAT(refusal([](Hello& h) { h.axes = 1; }), HasSubstr("options.axes in the configuration is 3"));
  EXPECT_THAT(refusal([](Hello& h) { h.axes = 2; }), HasSubstr("3 (x, y, z) or 1 (z)"));
  EXPECT_THAT(refusal([](Hello& h) { h.unit = Unit::pascal; }), HasSubstr("sends Pa, options.unit"));
  EXPECT_THAT(refusal([](Hello& h) { h.unit = Unit{6}; }), HasSubstr("Pa, N, counts, uT or mm"));
  EXPECT_THAT(refusal([](Hello& h) { h.rate_hz = 1000; }), HasSubstr("rate_hz in the configuration is 100"));
  EXPECT_THAT(refusal([](Hello& h) { h.rate_hz = std::nan(""); }), HasSubstr("no number of frames a second"));
  EXPECT_THAT(refusal([](Hello& h) { h.zero = Zero::measured; }), HasSubstr("options.zeroed"));
  EXPECT_THAT(refusal([](Hello& h) { h.version = 2; }), HasSubstr("version 2"));
  EXPECT_THAT(refusal([](Hello& h) { h.reserved[6] = 1; }),
              HasSubstr("fields that this slipd does not know"));
  EXPECT_THAT(refusal([](Hello& h) { h.magic[0] = 'S'; }), HasSubstr("no hello"));
  EXPECT_EQ(answer_to(good).code, Answer::accepted);
}

TEST_F(Push, NeedsAUnitFromTheProgramOrTheConfiguration) {
  open();
  const auto answer = answer_to({.taxels = kPushedTaxels});
  EXPECT_EQ(answer.code, Answer::refused);
  EXPECT_THAT(answer.text, HasSubstr("says the unit"));
}

TEST_F(Push, TellsASecondProgramThatThereIsOneAndServesItOnceThatHasGone) {
  open(json::object(), 0.2);  // a program so slow is not soon taken for one that hangs
  {
    PushWriter first = accepted();
    const auto answer = answer_to({.unit = Unit::pascal, .taxels = kPushedTaxels});
    EXPECT_EQ(answer.code, Answer::busy);
    EXPECT_THAT(answer.text, HasSubstr(std::to_string(::getpid())));
    EXPECT_EQ(becomes(first, {.sequence = 1}, values_), ReadStatus::frame) << "the first goes on";
  }
  accepted();
}

TEST_F(Push, AProgramThatHangsLosesItsPlaceToTheNextOneAndIsTold) {
  open();
  PushWriter hanging = accepted();
  becomes(hanging, {.sequence = 1}, values_);
  EXPECT_TRUE(reads(ReadStatus::away));
  EXPECT_THAT(driver_->why_no_frames(), HasSubstr("sends nothing"));
  PushWriter next = accepted();
  EXPECT_EQ(becomes(next, {.sequence = 1}, values_), ReadStatus::frame);
  EXPECT_FALSE(hanging.push(values_, {.sequence = 2}));
  EXPECT_EQ(hanging.answer(MSG_DONTWAIT).code, Answer::replaced);
}

TEST_F(Push, AContradictionDoesNotCostTheOneThatHangsItsPlace) {
  open();
  PushWriter hanging = accepted();
  becomes(hanging, {.sequence = 1}, values_);
  EXPECT_TRUE(reads(ReadStatus::away));
  EXPECT_EQ(answer_to({.unit = Unit::pascal, .taxels = 9}).code, Answer::refused);
  EXPECT_EQ(becomes(hanging, {.sequence = 2}, values_), ReadStatus::frame);
}

TEST_F(Push, AConnectionWithoutAHelloDoesNotKeepOthersOut) {
  open();
  const PushWriter silent(path_);
  PushWriter next(path_);
  next.hello({.unit = Unit::pascal, .taxels = kPushedTaxels});
  PushWriter::Answer answer;
  const auto give_up = std::chrono::steady_clock::now() + testing::kPatience;
  do {
    read();
    answer = next.answer(MSG_DONTWAIT);
  } while (answer.code == Answer{0xFFFF'FFFF} && std::chrono::steady_clock::now() < give_up);
  EXPECT_EQ(answer.code, Answer::accepted);
}

TEST_F(Push, SaysThatItIsAwayUntilAFrameComesAndWhy) {
  open();
  EXPECT_EQ(read().status, ReadStatus::away);
  EXPECT_THAT(driver_->why_no_frames(), HasSubstr("no program is connected to " + path_.string()));
  answer_to({.unit = Unit::pascal, .taxels = 5});
  EXPECT_THAT(driver_->why_no_frames(), HasSubstr("was refused: left: the program sends 5 taxels"));
  PushWriter writer = accepted();
  becomes(writer, {.sequence = 1}, {1});
  EXPECT_THAT(driver_->why_no_frames(), HasSubstr("had not the size of a frame"));
  EXPECT_EQ(becomes(writer, {.sequence = 1}, values_), ReadStatus::frame);
  EXPECT_EQ(read().status, ReadStatus::timeout);
}

TEST_F(Push, AProgramThatNeverWaitsIsReadAtTwiceTheRateAndItsOldFramesAreNotUsed) {
  open(json::object(), 1000);
  PushWriter writer = accepted();
  const auto begun = std::chrono::steady_clock::now();
  int read_messages = 0;
  std::uint64_t sequence = 0;
  while (std::chrono::steady_clock::now() - begun < 1s) {
    while (writer.push(values_, {.sequence = ++sequence}, MSG_DONTWAIT)) {
    }
    const ReadStatus status = read().status;
    read_messages += status == ReadStatus::corrupt || status == ReadStatus::frame ? 1 : 0;
    EXPECT_NE(status, ReadStatus::frame) << "another one waits, so it is not of now";
  }
  const double second = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  EXPECT_LE(read_messages, 2000 * second + 2000 * 0.1 + 1)
      << "twice the rate, and a burst of a tenth of a second";
}

TEST_F(Push, OpensAnewForFramesOfAnotherKindAndKeepsTheProgram) {
  EXPECT_EQ(open().sensors[0].sensor_class, SensorClass::array3);
  PushWriter writer(path_);
  writer.hello({.axes = 1, .unit = Unit::counts, .taxels = kPushedTaxels});
  ASSERT_TRUE(reads(ReadStatus::changed));
  EXPECT_EQ(writer.answer(MSG_DONTWAIT).code, Answer{0xFFFF'FFFF}) << "only once it is open";
  driver_->close();
  const DeviceInfo info = driver_->open();
  EXPECT_EQ(info.sensors[0].sensor_class, SensorClass::normal);
  EXPECT_FALSE(info.sensors[0].calibrated);
  EXPECT_EQ(writer.answer(MSG_DONTWAIT).code, Answer::accepted);
  ASSERT_EQ(becomes(writer, {.sequence = 1}, {1, 2, 3, 4}), ReadStatus::frame);
  EXPECT_THAT(owned_.slot.normal_pa, ::testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(owned_.slot.shear_x_pa, ::testing::Each(0));
}

TEST_F(Push, CountsAndMicroteslaArePressuresOnlyWithAScaleAndNeverZeroedWithout) {
  EXPECT_TRUE(open({{"unit", "N"}}).sensors[0].calibrated);
  EXPECT_FALSE(open({{"unit", "uT"}, {"zeroed", true}}).sensors[0].calibrated);
  EXPECT_FALSE(open({{"unit", "uT"}, {"zeroed", true}}).sensors[0].zeroed);
  EXPECT_TRUE(open({{"unit", "uT"}, {"zeroed", true}, {"scale", 3}}).sensors[0].calibrated);
  EXPECT_TRUE(open({{"unit", "uT"}, {"zeroed", true}, {"scale", 3}}).sensors[0].zeroed);
}

TEST_F(Push, ItsFileHasTheConfiguredModeAndGoesWithIt) {
  open({{"mode", "0600"}});
  struct stat made {};
  ASSERT_EQ(::stat(path_.c_str(), &made), 0);
  EXPECT_EQ(made.st_mode & 07777, 0600U);
  driver_->close();
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(Push, DoesNotTakeASocketOfAnotherProgramAndReplacesADeadOne) {
  open();
  push::PushDriver second({setup_of(TaxelLayout::grid(2, 2, kPitchM), {{"path", path_.string()}})});
  EXPECT_THAT(refusal_of([&] { second.open(); }), HasSubstr("in use by another program"));
  driver_.reset();
  { std::ofstream(path_) << "mine"; }
  EXPECT_THAT(refusal_of([&] { second.open(); }), HasSubstr("no socket"));
  std::filesystem::remove(path_);
  {
    const UniqueFd dead(::socket(AF_UNIX, SOCK_SEQPACKET, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  EXPECT_EQ(refusal_of([&] { second.open(); }), "");
}

TEST_F(Push, RefusesWhatCannotWorkAndSaysWhatToDo) {
  const auto refusal = [&](const TaxelLayout& layout, const json& options) {
    return refusal_of([&] { push::PushDriver driver({setup_of(layout, options)}); });
  };
  const TaxelLayout small = TaxelLayout::grid(2, 2, kPitchM);
  EXPECT_THAT(refusal(small, {{"path", std::string(108, 'a')}}), HasSubstr("give options.path"));
  EXPECT_THAT(refusal(TaxelLayout::grid(200, 200, kPitchM), {{"path", "a"}}), HasSubstr("40000 taxels"));
  EXPECT_THAT(refusal_of([&] { open({{"group", "no-such-group"}}); }), HasSubstr("no such group"));
  std::filesystem::create_directory(folder_.file("open"));
  std::filesystem::permissions(folder_.file("open"), std::filesystem::perms::all);
  EXPECT_THAT(refusal_of([&] {
                open({{"path", folder_.file("open") / "left"}});
              }),
              HasSubstr("everybody may write to it"));
}

// Taxels are converted four at a time: nine have two such groups and one left over.
TEST(PushedFrames, EachValueHasItsPlaceAndNoneMayBeInfinite) {
  const SensorSetup setup = setup_of(TaxelLayout::grid(3, 3, kPitchM), json::object());
  push::Options options;
  options.max_age_ns = 1'000'000'000;
  options.scale = std::array<float, 3>{2, 3, 5};
  for (const std::size_t axes : {3, 1}) {
    options.axes = static_cast<std::uint8_t>(axes);
    push::FrameReader reader(options.max_age_ns);
    reader.begin(push::agreement_without_hello(options, setup));
    OwnedSlot owned(9);
    std::vector<float> values(9 * axes);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i + 1);
    std::uint64_t sequence = 0;
    const auto taken = [&] {
      const std::vector<char> message = PushWriter::frame(values, {.sequence = ++sequence});
      const std::vector<std::uint8_t> bytes(message.begin(), message.end());
      return reader.take(bytes, static_cast<std::int64_t>(sequence), false, owned.slot);
    };
    ASSERT_EQ(taken(), push::Refusal::none);
    for (std::size_t i = 0; i < 9; ++i) {
      EXPECT_EQ(owned.slot.normal_pa[i], 5 * values[axes * i + axes - 1]);
      EXPECT_EQ(owned.slot.shear_x_pa[i], axes == 3 ? 2 * values[3 * i] : 0);
      EXPECT_EQ(owned.slot.shear_y_pa[i], axes == 3 ? 3 * values[3 * i + 1] : 0);
    }
    for (float& value : values) {
      const float before = std::exchange(value, std::numeric_limits<float>::infinity());
      EXPECT_EQ(taken(), push::Refusal::not_finite) << &value - values.data();
      value = before;
    }
  }
}

TEST_F(Push, TheLongestFrameComesWhole) {
  const TaxelLayout layout = TaxelLayout::grid(133, 133, kPitchM);
  ASSERT_GT(push_layout::frame_size(layout.size() + 16, 3), push_layout::kLongestMessage);
  push::PushDriver driver({setup_of(layout, {{"path", path_.string()}, {"max_age_ms", 10'000}})});
  driver.open();
  PushWriter writer(path_);
  writer.hello({.unit = Unit::pascal, .taxels = static_cast<std::uint32_t>(layout.size())});
  OwnedSlot large(layout.size());
  std::array slots{large.slot};
  driver.read(slots, 20ms);
  std::vector<float> values(3 * layout.size());
  values.back() = 7;
  ASSERT_TRUE(writer.push(values, {.sequence = 1}));
  EXPECT_EQ(driver.read(slots, 20ms).status, ReadStatus::frame);
  EXPECT_EQ(large.slot.normal_pa.back(), 7);
}

TEST_F(Push, ItsSocketIsBesideThatOfSlipdUnlessConfigured) {
  SensorSetup setup = setup_of(TaxelLayout::grid(2, 2, kPitchM), json::object());
  setup.runtime_folder = folder_.path().string();
  push::PushDriver driver({setup});
  driver.open();
  EXPECT_TRUE(PushWriter(folder_.path() / "push" / "left").is_connected());
}

TEST_F(Push, ReadingAllocatesNothingWhateverComes) {
  open(json::object(), 0.2);
  const auto allocated = [&] {
    const std::uint64_t before = allocations();
    for (int i = 0; i < 4; ++i) read();
    return allocations() - before;
  };
  std::optional<PushWriter> writer(path_);
  writer->hello({.unit = Unit::pascal, .taxels = kPushedTaxels});
  EXPECT_EQ(allocated(), 0) << "an acceptance";
  writer->push(values_, {.sequence = 1});
  writer->push({1}, {.sequence = 2});
  EXPECT_EQ(allocated(), 0) << "a frame, and a torn one";
  const PushWriter second(path_);
  EXPECT_EQ(allocated(), 0) << "a second program";
  writer.reset();
  EXPECT_EQ(allocated(), 0) << "the end of the first";
  PushWriter third(path_);
  third.hello({.unit = Unit::pascal, .taxels = 9});
  EXPECT_EQ(allocated(), 0) << "a contradiction";
}

}  // namespace
}  // namespace slipd::test
