// The files of the flight recorder: the seconds around an alert, a limited number of files, none of them
// partial.
#include "daemon/record/flight_recorder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <set>

#include "daemon/record/frame_history.hpp"
#include "daemon/record/request_rate.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;
using testing::TempFolder;

struct OwnedFrame {
  explicit OwnedFrame(std::uint64_t sequence, std::size_t taxels = 4)
      : normal(taxels, static_cast<float>(sequence)), x(taxels), y(taxels) {
    slot.sequence = sequence;
    slot.normal_pa = normal;
    slot.shear_x_pa = x;
    slot.shear_y_pa = y;
  }
  std::vector<float> normal, x, y;
  FrameSlot slot;
};

TEST(FrameHistory, HoldsTheNewestInTheirOrder) {
  for (const std::uint64_t count : {0, 1, 4, 5, 6, 23}) {
    FrameHistory history(4, 5);
    for (std::uint64_t i = 1; i <= count; ++i) history.push(OwnedFrame(i).slot);
    ASSERT_EQ(history.size(), std::min<std::uint64_t>(count, 5));
    for (std::size_t i = 0; i < history.size(); ++i) {
      EXPECT_EQ(history[i].sequence, count - history.size() + 1 + i);
      EXPECT_EQ(history[i].normal_pa.front(), static_cast<float>(history[i].sequence));
    }
  }
}

TEST(FrameHistory, HasTheEstimateOfEachFrame) {
  FrameHistory history(4, 5);
  const auto estimate_at = [](std::int64_t time) {
    return RecordedEstimate{.gamma = static_cast<double>(time) * 0.01};
  };
  for (std::int64_t time = 1; time <= 8; ++time) {
    OwnedFrame frame(static_cast<std::uint64_t>(time));
    frame.slot.time_ns = 10 * time;
    history.push(frame.slot);
    if (time % 2 == 0) history.attach_estimate(10 * time, estimate_at(time));
  }
  history.attach_estimate(
      80, {.state = 6});  // what is said when nothing more comes: the frame has its own already
  history.attach_estimate(10, estimate_at(1));  // of a frame that was overwritten
  history.attach_estimate(75, estimate_at(7));  // of no frame
  history.attach_estimate(50, estimate_at(5));  // late
  ASSERT_EQ(history.size(), 5U);                // frames 4 to 8
  for (std::size_t i = 0; i < 5; ++i) {
    const std::int64_t time = history[i].time_ns / 10;
    if (time == 7) {
      EXPECT_EQ(history.estimate(i), nullptr);
    } else {
      ASSERT_NE(history.estimate(i), nullptr) << time;
      EXPECT_EQ(history.estimate(i)->gamma, static_cast<double>(time) * 0.01);
    }
  }
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& item : fs::directory_iterator(folder)) names.insert(item.path().filename());
  return names;
}

TEST(RecordingsFolder, KeepsTheNewestAndLeavesOtherFilesAlone) {
  const TempFolder temp;
  temp.write("notes.txt", "mine");
  const RecordingsFolder folder(temp.path(), 3);
  for (int i = 0; i < 7; ++i) {
    const std::string name = "f" + std::to_string(i);
    EXPECT_FALSE(folder.add(name, "slip", [](int) { return std::error_code(); }));
    fs::last_write_time(temp.path() / (name + "-slip.rec"),
                        fs::file_time_type::clock::now() - std::chrono::hours(10 - i));
  }
  EXPECT_EQ(names_in(temp.path()),
            (std::set<std::string>{"f4-slip.rec", "f5-slip.rec", "f6-slip.rec", "notes.txt"}));
}

TEST(RecordingsFolder, TheLastWrittenIsTheNewestAlsoWhereTheClockWasSetBack) {
  const testing::TempFolder temp;
  const RecordingsFolder folder(temp.path(), 2);
  const auto add = [&](const std::string& name) {
    return folder.add(name, "slip", [](int) { return std::error_code(); });
  };
  ASSERT_FALSE(add("a"));
  const auto tomorrow = std::filesystem::file_time_type::clock::now() + std::chrono::hours(24);
  std::filesystem::last_write_time(temp.file("a-slip.rec"), tomorrow);
  for (const char* name : {"b", "c", "d"}) ASSERT_FALSE(add(name));
  EXPECT_FALSE(std::filesystem::exists(temp.file("a-slip.rec")));
  EXPECT_FALSE(std::filesystem::exists(temp.file("b-slip.rec")));
  EXPECT_TRUE(std::filesystem::exists(temp.file("c-slip.rec")));
  EXPECT_TRUE(std::filesystem::exists(temp.file("d-slip.rec")));
}

TEST(RecordingsFolder, HasALimitForEachKindOfItsOwn) {
  const TempFolder temp;
  temp.write("copied.rec", "mine");
  const RecordingsFolder folder(temp.path(), 2);
  const auto add = [&](const std::string& name, const char* kind) {
    ASSERT_FALSE(folder.add(name, kind, [](int) { return std::error_code(); }));
  };
  add("a", "slip");
  for (const char* name : {"b", "c", "d", "e"}) add(name, "request");
  EXPECT_EQ(names_in(temp.path()),
            (std::set<std::string>{"a-slip.rec", "copied.rec", "d-request.rec", "e-request.rec"}));
  for (const char* name : {"f", "g"}) add(name, "slip");
  EXPECT_EQ(names_in(temp.path()), (std::set<std::string>{"copied.rec", "d-request.rec", "e-request.rec",
                                                          "f-slip.rec", "g-slip.rec"}));
}

TEST(RequestRate, GrantsABurstAndThenSoManyASecond) {
  RequestRate rate(2, 3);
  const auto begin = RequestRate::Clock::now();
  int granted = 0;
  for (int i = 0; i < 10; ++i) granted += rate.grant(begin) ? 1 : 0;
  EXPECT_EQ(granted, 3);
  EXPECT_EQ(rate.wait_s(), 1);
  granted = 0;
  for (int i = 0; i < 100; ++i) granted += rate.grant(begin + std::chrono::milliseconds(100 * i)) ? 1 : 0;
  EXPECT_NEAR(granted, 20, 1);
}

TEST(RecordingsFolder, PartialFilesOfACrashAreRemoved) {
  const TempFolder temp;
  temp.write("crashed.rec.part", "half");
  fs::last_write_time(temp.path() / "crashed.rec.part",
                      fs::file_time_type::clock::now() - std::chrono::hours(1));
  temp.write("under-way.rec.part", "half");
  EXPECT_FALSE(RecordingsFolder(temp.path(), 3).add("f", "slip", [](int) { return std::error_code(); }));
  EXPECT_EQ(names_in(temp.path()), (std::set<std::string>{"f-slip.rec", "under-way.rec.part"}));
}

TEST(RecordingsFolder, DoesNotWriteThroughALinkInItsPlace) {
  const TempFolder temp;
  const fs::path precious = temp.write("precious", "mine");
  const TempFolder kept;
  for (const char* name : {"a-slip.rec.part", "a-slip.rec"}) fs::create_symlink(precious, kept.path() / name);
  const RecordingsFolder folder(kept.path(), 3);
  EXPECT_FALSE(folder.add("a", "slip", [](int fd) {
    return write(fd, "frames", 6) == 6 ? std::error_code() : std::make_error_code(std::errc::io_error);
  }));
  EXPECT_EQ(fs::file_size(precious), 4U);
  EXPECT_FALSE(fs::is_symlink(kept.path() / "a-slip.rec"));
  EXPECT_EQ(names_in(kept.path()), std::set<std::string>{"a-slip.rec"});
}

TEST(RecordingsFolder, ItsGroupMayReadWhateverTheUmask) {
  const TempFolder temp;
  const mode_t before = umask(0077);
  const RecordingsFolder folder(temp.file("recordings"), 1);
  EXPECT_FALSE(folder.add("a", "slip", [](int) { return std::error_code(); }));
  umask(before);
  EXPECT_EQ(fs::status(folder.path()).permissions(), fs::perms(0750));
  EXPECT_EQ(fs::status(folder.path() / "a-slip.rec").permissions(), fs::perms(0640));
}

TEST(RecordingsFolder, AFileThatCannotBeWrittenLeavesNothingAndCostsNoOther) {
  const TempFolder temp;
  const RecordingsFolder folder(temp.path(), 1);
  ASSERT_FALSE(folder.add("first", "slip", [](int) { return std::error_code(); }));
  const auto full = std::make_error_code(std::errc::no_space_on_device);
  EXPECT_EQ(folder.add("second", "slip", [&](int) { return full; }), full);
  EXPECT_EQ(names_in(temp.path()), std::set<std::string>{"first-slip.rec"});
}

}  // namespace
}  // namespace slipd
