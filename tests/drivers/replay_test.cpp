// A replay returns the file's frames at the configured speed up to a fault, and reports the fault's place.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "core/recording/recording.hpp"
#include "drivers/pacing.hpp"
#include "drivers/replay/playlist.hpp"
#include "drivers/replay/replay_driver.hpp"
#include "tests/drivers/replay_fixture.hpp"

namespace slipd::replay {
namespace {

using std::chrono::microseconds;
using test::opening;
using test::OwnedSlot;
using test::play;
using test::play_whole;
using test::refusal_of;
using test::setup_of;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kTwoTaxels = "txl1_x,txl1_y,txl1_z,txl2_x,txl2_y,txl2_z";
const auto kPair = TaxelLayout::grid(2, 1, 0.004);

class Replays : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("slipd-replay-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  static SensorSetup setup(const std::string& file, nlohmann::json more = nlohmann::json::object()) {
    more["file"] = file;
    if (!more.contains("speed")) more["speed"] = 0;
    return setup_of(kPair, std::move(more), 100);
  }
  std::string record(const std::string& name, std::size_t frames, std::uint64_t step = 1) const {
    const int fd = ::open((folder_ / name).c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600);
    RecordingWriter writer(fd, {"left", SensorClass::array3, kPair, 1000, true, 1, 1, ""});
    OwnedSlot slot(2);
    for (std::size_t i = 0; i < frames; ++i) {
      slot.memory.assign(6, static_cast<float>(i));
      slot.slot.sequence = 100 + step * i;
      slot.slot.time_ns = 5000000 + static_cast<std::int64_t>(i) * 1000000;
      slot.slot.truth.gamma = 0.5;
      EXPECT_FALSE(writer.append(slot.slot));
    }
    EXPECT_FALSE(writer.finish());
    ::close(fd);
    return folder_ / name;
  }

  std::filesystem::path folder_;
};

TEST_F(Replays, OfCsvPutEachColumnWhereItBelongsInWhateverOrderTheyStand) {
  const auto played = play_whole(setup(file(
      "a.csv",
      "note,txl2_z,txl1_x,txl1_y,txl1_z,txl2_x,txl2_y\r\nhello, 6.5,1,2,3,+4,-5e1\r\n\r\n,12,7,8,9,10,11")));
  ASSERT_EQ(played.frames.size(), 2U);
  EXPECT_EQ(played.values[0], (std::vector<float>{3, 6.5, 1, 4, 2, -50}));
  EXPECT_EQ(played.values[1], (std::vector<float>{9, 12, 7, 10, 8, 11}));
  EXPECT_EQ(played.last, ReadStatus::end);
}

TEST_F(Replays, TurnCountsIntoPascalByBiasAndScale) {
  const auto path = file("a.csv", std::string(kTwoTaxels) + "\n11,12,13,21,22,23\n");
  EXPECT_EQ(play_whole(setup(path, {{"bias", 10}, {"scale", 2}})).values[0],
            (std::vector<float>{6, 26, 2, 22, 4, 24}));
  EXPECT_EQ(play_whole(setup(path, {{"bias", {1, 2, 3}}, {"scale", {1, -1, 10}}})).values[0],
            (std::vector<float>{100, 200, 10, 20, -10, -20}));
  EXPECT_EQ(play_whole(setup(path, {{"bias", {11, 12, 13, 21, 22, 22}}})).values[0],
            (std::vector<float>{0, 1, 0, 0, 0, 0}));
  EXPECT_THAT(opening(setup(path, {{"bias", {1, 2, 3, 4}}})), HasSubstr("bias has 4 values"));
}

TEST_F(Replays, OfNewtonsAreDividedByATaxelsArea) {
  const auto path = file("a.csv", std::string(kTwoTaxels) + "\n1,2,3,-1,0,0.5\n");
  const float area_m2 = 16e-6F;  // of 4 mm by 4 mm
  const auto played = play_whole(setup(path, {{"unit", "N"}})).values[0];
  const std::vector<float> forces{3, 0.5, 1, -1, 2, 0};
  for (std::size_t i = 0; i < forces.size(); ++i) EXPECT_FLOAT_EQ(played[i], forces[i] / area_m2) << i;
  const auto scaled = play_whole(setup(path, {{"unit", "N"}, {"bias", 1}, {"scale", 2}})).values[0];
  for (std::size_t i = 0; i < forces.size(); ++i)
    EXPECT_FLOAT_EQ(scaled[i], 2 * (forces[i] - 1) / area_m2) << "bias and scale come first, " << i;
}

TEST_F(Replays, OfRawCountsKeepThemAndHaveNoZero) {
  const auto path = file("a.csv", std::string(kTwoTaxels) + "\n1,2,3,4,5,6\n");
  ReplayDriver raw({setup(path, {{"unit", "raw"}})}), pascal({setup(path)});
  EXPECT_FALSE(raw.open().sensors.at(0).zeroed);
  EXPECT_TRUE(pascal.open().sensors.at(0).zeroed);
  EXPECT_EQ(play(raw, 2).values.at(0), (std::vector<float>{3, 6, 1, 4, 2, 5}));
}

TEST_F(Replays, TakeTheColumnsOfTheTaxelsThatAreNamedInThatOrder) {
  const auto path =
      file("a.csv", "txl1_x,txl1_y,txl1_z,txl7_x,txl7_y,txl7_z,thumb_x,thumb_y,thumb_z\n1,2,3,4,5,6,7,8,9\n");
  EXPECT_EQ(play_whole(setup(path, {{"taxels", {"thumb", "txl7"}}})).values.at(0),
            (std::vector<float>{9, 6, 7, 4, 8, 5}));
  EXPECT_THAT(opening(setup(path, {{"taxels", {"thumb"}}})), HasSubstr("taxels"));
  EXPECT_THAT(opening(setup(path, {{"taxels", {"thumb", "thumb"}}})), HasSubstr("thumb"));
  EXPECT_THAT(opening(setup(path, {{"taxels", {"thumb", "index"}}})), HasSubstr("index"));
}

TEST_F(Replays, KeepTheTimesOfTheFileOrTheRateOfTheSensor) {
  const auto timed =
      play_whole(setup(file("a.csv", "time," + std::string(kTwoTaxels) +
                                         "\n7.0,1,1,1,1,1,1\n7.25,1,1,1,1,1,1\n7.25,1,1,1,1,1,1\n")));
  ASSERT_EQ(timed.frames.size(), 3U);
  EXPECT_EQ(timed.frames[1].time_ns - timed.frames[0].time_ns, 250000000);
  EXPECT_EQ(timed.frames[2].time_ns - timed.frames[1].time_ns,
            1);  // stamps rise even where the file's clock stands
  const auto rated =
      play_whole(setup(file("b.csv", std::string(kTwoTaxels) + "\n1,1,1,1,1,1\n1,1,1,1,1,1\n")));
  EXPECT_EQ(rated.frames[1].time_ns - rated.frames[0].time_ns, 10000000);
}

TEST_F(Replays, CountTheRowsWhoseTimeDoesNotRise) {
  const auto unrisen = [this](const std::vector<std::string>& times) {
    std::string text = "time," + std::string(kTwoTaxels) + "\n";
    for (const std::string& time : times) text += time + ",1,1,1,1,1,1\n";
    const SensorSetup sensor = setup(file("a.csv", text));
    Playlist list(sensor, parse_options(sensor));
    OwnedSlot slot(2);
    while (list.next(slot.slot) == ReadOutcome::frame) continue;
    return list.unrisen();
  };
  EXPECT_EQ(unrisen({"7", "7.01", "7.02"}), 0U);
  EXPECT_EQ(unrisen({"7", "7", "7"}), 2U) << "constant";
  EXPECT_EQ(unrisen({"7", "7.01", "7.01", "7.02"}), 1U) << "repeated";
  EXPECT_EQ(unrisen({"7", "7.01", "2", "2.01"}), 1U) << "jumps back";
}

TEST_F(Replays, AreRefusedIfTheirTimesHaveAnotherName) {
  for (const std::string name : {"Time", "timestamp", "t", "TIME_S"}) {
    const auto path = file("a.csv", std::string(kTwoTaxels) + "," + name + "\n1,1,1,1,1,1,7\n");
    EXPECT_THAT(opening(setup(path)), HasSubstr("a.csv: line 1, column 7: " + name + " is no name that is"));
  }
  EXPECT_THAT(opening(setup(file("b.csv", "time," + std::string(kTwoTaxels) + ",timestamp\n"))), IsEmpty())
      << "there is a time already";
  EXPECT_THAT(opening(setup(file("c.csv", std::string(kTwoTaxels) + ",trial\n"))), IsEmpty());
}

TEST_F(Replays, AreRefusedWhenTheDataDoNotFitTheLayout) {
  const auto csv = file("a.csv", std::string(kTwoTaxels) + ",txl3_x\n");
  EXPECT_THAT(opening(setup(csv)), HasSubstr("line 1, column 7: txl3_x is beyond the 2 taxels"));
  EXPECT_THAT(opening(setup(file("b.csv", "txl1_x,txl1_y,txl1_z\n1,2,3\n"))),
              HasSubstr("line 1: no column txl2_x"));
  EXPECT_THAT(opening(setup(file("c.csv", std::string(kTwoTaxels) + ",txl1_x\n"))),
              HasSubstr("a second column txl1_x"));
  auto other = setup(record("d.cbor", 1));
  EXPECT_THAT(opening(other), IsEmpty());
  other.layout = TaxelLayout::grid(2, 1, 0.005);
  EXPECT_THAT(opening(other), HasSubstr("{ \"grid\": [2, 1], \"pitch_mm\": 4 }"));
}

TEST_F(Replays, OfNothingUsefulAreRefusedWithTheName) {
  EXPECT_THAT(opening(setup(folder_ / "none")), HasSubstr("none"));
  EXPECT_THAT(opening(setup(folder_)), HasSubstr("a folder without any"));
  EXPECT_THAT(opening(setup(file("a.csv", ""))), HasSubstr("empty"));
  EXPECT_THAT(opening(setup(file("b.cbor", "\xA1\x61"))), HasSubstr("byte 2"));
}

TEST_F(Replays, OfFaultyCsvGiveTheRowsBeforeAndNameLineAndColumn) {
  const std::string start = std::string(kTwoTaxels) + "\n1,2,3,4,5,6\n";
  const auto fault_of = [this](const std::string& content, std::size_t frames_before) {
    const auto path = file("a.csv", content);
    ReplayDriver driver({setup(path)});
    driver.open();
    const auto played = play(driver, 2);
    EXPECT_EQ(played.frames.size(), frames_before);
    EXPECT_EQ(played.last, ReadStatus::disconnected);
    driver.close();
    return refusal_of([&] { driver.open(); });
  };
  EXPECT_THAT(fault_of(start + "1,2,x\x01y,4,5,6\n", 1),
              HasSubstr("a.csv: line 3, column 3 (txl1_z): \"x?y\" is no number"));
  EXPECT_THAT(fault_of(start + "1,2,3,4,5", 1), HasSubstr("line 3, column 6 (txl2_z): the line ends before"));
  EXPECT_THAT(fault_of(start + start.substr(start.find('\n') + 1) + "1,2,3,4,5,6,7\n", 2),
              HasSubstr("line 4, column 7: \"7\" is one"));
  EXPECT_THAT(fault_of(start + std::string(200000, '1'), 1), HasSubstr("line 3: is longer than any frame's"));
}

TEST_F(Replays, OfARepairedFilePlayAgain) {
  const std::string start = std::string(kTwoTaxels) + "\n1,2,3,4,5,6\n";
  const auto path = file("a.csv", start + "1,2\n");
  ReplayDriver driver({setup(path)});
  driver.open();
  EXPECT_EQ(play(driver, 2).last, ReadStatus::disconnected);
  EXPECT_THROW(driver.open(), DriverError);
  file("a.csv", start);
  std::filesystem::last_write_time(path,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(10));
  driver.open();
  EXPECT_EQ(play(driver, 2).last, ReadStatus::end);
}

TEST_F(Replays, OfTruncatedRecordingsGiveAllBlocksBeforeTheCut) {
  const auto path = record("a.cbor", 10);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 5);
  ReplayDriver driver({setup(path)});
  driver.open();
  const auto played = play(driver, 2);
  EXPECT_EQ(played.frames.size(), 10U) << "the cut is in the index";
  EXPECT_EQ(played.last, ReadStatus::disconnected);
  EXPECT_THAT(refusal_of([&] { driver.open(); }), HasSubstr("the recording ends within"));
}

TEST_F(Replays, OfDamagedRecordingsLeaveTheDamagedBlocksOutAndCountThem) {
  constexpr std::size_t kFrames = 5000;  // in blocks of 64 KiB
  const auto path = record("a.cbor", kFrames);
  {
    std::fstream content(path, std::ios::in | std::ios::out | std::ios::binary);
    content.seekp(200'000);
    const float wrong = 1e30F;
    content.write(reinterpret_cast<const char*>(&wrong), sizeof wrong);
  }
  ReplayDriver driver({setup(path)});
  driver.open();
  const auto played = play(driver, 2);
  EXPECT_LT(played.frames.size(), kFrames);
  EXPECT_GT(played.frames.size(), kFrames - 600);
  EXPECT_EQ(played.corrupt, 1);
  for (std::size_t i = 0; i < played.frames.size(); ++i)
    EXPECT_EQ(played.values[i][0], static_cast<float>(played.frames[i].sequence - 1));
  EXPECT_EQ(played.last, ReadStatus::disconnected);
  EXPECT_THAT(refusal_of([&] { driver.open(); }), HasSubstr("damaged; 1 block with"));
  ReplayDriver looping({setup(path, {{"loop", true}})});
  looping.open();
  EXPECT_EQ(play(looping, 2, 3 * kFrames).last, ReadStatus::frame) << "a loop goes on";
}

TEST_F(Replays, OfEmptyLinesWithoutEndSayThatTheyAreNoFrames) {
  const auto path = file("a.csv", std::string(kTwoTaxels) + "\n1,2,3,4,5,6\n" + std::string(1'000'000, '\n'));
  ReplayDriver driver({setup(path, {{"loop", true}})});
  driver.open();
  const auto played = play(driver, 2);
  EXPECT_EQ(played.frames.size(), 1U);
  EXPECT_EQ(played.last, ReadStatus::disconnected);
  EXPECT_THAT(refusal_of([&] { driver.open(); }), HasSubstr("are empty: no table of frames"));
}

TEST_F(Replays, AtSpeedZeroLoseNothingAndArePacedByTheConsumer) {
  ReplayDriver driver({setup(record("a.cbor", 2000))});
  driver.open();
  EXPECT_TRUE(driver.paced_by_consumer());
  const auto played = play(driver, 2);
  ASSERT_EQ(played.frames.size(), 2000U);
  for (std::size_t i = 0; i < played.frames.size(); ++i) {
    EXPECT_EQ(played.values[i][0], static_cast<float>(i));
    EXPECT_EQ(played.frames[i].sequence, i + 1);
    EXPECT_EQ(played.frames[i].truth.gamma, 0.5);
    if (i > 0) {
      EXPECT_EQ(played.frames[i].time_ns - played.frames[i - 1].time_ns, 1000000);
    }
  }
}

TEST_F(Replays, TellOfTheGapsThatWereRecorded) {
  const auto played = play_whole(setup(record("a.cbor", 3, 4)));
  EXPECT_EQ(played.frames[2].sequence - played.frames[0].sequence, 8U);
}

TEST_F(Replays, OfFoldersPlayTheFilesInOrderAndLoopWithoutATimeThatGoesBack) {
  record("b.rec", 3);
  file("a.csv", std::string(kTwoTaxels) + "\n50,50,50,50,50,50\n");
  file("readme.txt", "no data");
  EXPECT_EQ(play_whole(setup(folder_)).frames.size(), 4U);
  ReplayDriver driver({setup(folder_, {{"loop", true}})});
  EXPECT_TRUE(driver.open().simulated);
  const auto played = play(driver, 2, 40);
  ASSERT_EQ(played.frames.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(played.values[i][0], i % 4 == 0 ? 50 : static_cast<float>(i % 4 - 1));
    EXPECT_EQ(played.frames[i].sequence, i + 1);
    if (i > 0) {
      EXPECT_GT(played.frames[i].time_ns, played.frames[i - 1].time_ns);
    }
  }
  ReplayDriver empty({setup(file("a.csv", std::string(kTwoTaxels) + "\n"), {{"loop", true}})});
  empty.open();
  EXPECT_EQ(play(empty, 2).last, ReadStatus::end);
}

TEST_F(Replays, AtASpeedHandOutEachFrameNoEarlierThanItIsDue) {
  ReplayDriver driver({setup(record("a.cbor", 50), {{"speed", 5}})});
  const auto info = driver.open();
  EXPECT_EQ(info.sensors.at(0).rate_hz, 5000);
  EXPECT_FALSE(driver.paced_by_consumer());
  OwnedSlot slot(2);
  std::int64_t first_ns = 0;
  int frames = 0;
  for (ReadResult result; result.status != ReadStatus::end;) {
    result = driver.read({&slot.slot, 1}, microseconds(50));  // shorter than the 200 us between frames
    if (result.status != ReadStatus::frame) continue;
    EXPECT_GE(monotonic_ns(), slot.slot.time_ns);
    if (frames == 0) first_ns = slot.slot.time_ns;
    EXPECT_EQ(slot.slot.time_ns - first_ns, 200000 * frames);
    EXPECT_EQ(slot.memory[0], static_cast<float>(frames));
    ++frames;
  }
  EXPECT_EQ(frames, 50);
}

TEST_F(Replays, GiveUpWhenTheTimeGivenIsShorterThanTheWait) {
  ReplayDriver driver({setup(record("a.cbor", 2), {{"speed", 1e-7}})});  // the second frame is due in hours
  driver.open();
  OwnedSlot slot(2);
  while (driver.read({&slot.slot, 1}, microseconds(50)).status != ReadStatus::frame) {
  }
  EXPECT_EQ(driver.read({&slot.slot, 1}, microseconds(50)).status, ReadStatus::timeout);
}

TEST_F(Replays, PassOverRowsWithMissingValuesAndPlayTheRest) {
  const std::string rows =
      "1,2,3,4,5,6,0\n,2,3,4,5,6,0.1\n1,2,nan,4,5,6,0.2\n1,2,3,NA,5,6,0.3\n1,2,3,4,5,-inf,0.4\n"
      "1,2,3,4,5,6,\n1,2,3,4,5,7,0.6\n";
  const auto played = play_whole(setup(file("a.csv", std::string(kTwoTaxels) + ",time\n" + rows)));
  EXPECT_EQ(played.corrupt, 5);
  EXPECT_EQ(played.last, ReadStatus::end);
  ASSERT_EQ(played.frames.size(), 2U);
  EXPECT_EQ(played.values[1][1], 7);
  EXPECT_EQ(played.frames[1].sequence - played.frames[0].sequence, 6U);
  EXPECT_EQ(played.frames[1].time_ns - played.frames[0].time_ns, 600000000);
}

TEST_F(Replays, PassOverFramesThatAreNoNumbersAndCountThem) {
  const auto played =
      play_whole(setup(file("a.csv", std::string(kTwoTaxels) + "\n1e300,2,3,4,5,6\n1,2,3,4,5,6\n")));
  EXPECT_EQ(played.corrupt, 1);
  EXPECT_EQ(played.frames.size(), 1U);
}

TEST_F(Replays, OfCsvWithBytesAtRandomNeverCrashAndAlwaysSayWhere) {
  std::mt19937_64 random(5);  // NOLINT: the same bytes each time
  std::string whole = std::string(kTwoTaxels) + ",time\n";
  for (int i = 0; i < 5; ++i) whole += "1.5,-2,3e4,4,5,6," + std::to_string(i) + "\n";
  const std::string likely = "0123456789.,-+eE\n\r \"x_ntl\0\xff";
  int faults = 0;
  for (int round = 0; round < 400; ++round) {
    auto content = whole;
    for (auto flips = 1 + random() % 5; flips > 0; --flips)
      content[random() % content.size()] = likely[random() % likely.size()];
    ReplayDriver driver({setup(file("a.csv", content))});
    const auto refused = refusal_of([&] { driver.open(); });
    if (!refused.empty()) {
      EXPECT_THAT(refused, ::testing::AnyOf(HasSubstr("a.csv: line 1"), HasSubstr("a.csv: byte"))) << content;
      continue;
    }
    const auto played = play(driver, 2);
    EXPECT_LE(played.frames.size(), 10U);
    if (played.last != ReadStatus::disconnected) continue;
    ++faults;
    EXPECT_THAT(refusal_of([&] { driver.open(); }), HasSubstr("a.csv: line ")) << content;
  }
  EXPECT_GT(faults, 50);
}

}  // namespace
}  // namespace slipd::replay
