// Recordings of version 2: what is damaged is left out, reported and counted, and no frame comes back other
// than it was recorded.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "core/recording/recording.hpp"
#include "core/storage/unique_fd.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Status = RecordingReader::Status;
using namespace std::chrono_literals;

constexpr std::size_t kTaxels = 4;
constexpr std::size_t kFramesOfBlock = 5;

struct BlockFrame {
  explicit BlockFrame(std::size_t taxels = kTaxels) : memory(3 * taxels) {
    slot.normal_pa = std::span(memory).first(taxels);
    slot.shear_x_pa = std::span(memory).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(memory).last(taxels);
  }
  std::vector<float> memory;
  FrameSlot slot;
};

BlockFrame numbered_frame(std::uint64_t number, std::size_t taxels = kTaxels) {
  BlockFrame frame(taxels);
  for (std::size_t i = 0; i < frame.memory.size(); ++i)
    frame.memory[i] = std::cos(static_cast<float>(7 * number + i)) * 1e4F;
  frame.slot.sequence = number;
  frame.slot.time_ns = 1'000'000 * static_cast<std::int64_t>(number);
  frame.slot.device_time_ns = static_cast<std::int64_t>(number);
  frame.slot.truth = {0.5, 0.25};
  return frame;
}

RecordingHeader block_header(const TaxelLayout& layout = TaxelLayout::grid(2, 2, 0.001)) {
  return {"left", SensorClass::array3, layout, 1000, true, 1790000000000000000, 12345, "a test"};
}

// What was read of a recording: numbers of its frames, each equal to what was recorded.
struct ReadBack {
  std::vector<std::uint64_t> frames;
  std::uint64_t skipped = 0;
  std::string fault;
  Status last = Status::frame;
};

void expect_as_recorded(const BlockFrame& got) {
  const BlockFrame want = numbered_frame(got.slot.sequence);
  EXPECT_EQ(got.memory, want.memory);
  EXPECT_EQ(got.slot.time_ns, want.slot.time_ns);
  EXPECT_EQ(got.slot.device_time_ns, want.slot.device_time_ns);
  EXPECT_EQ(got.slot.truth.gamma, want.slot.truth.gamma);
  EXPECT_EQ(got.slot.truth.friction, want.slot.truth.friction);
}

class Blocks : public ::testing::Test {
 protected:
  // Leaves a recording of so many blocks behind; says where each of them begins, and where the index does.
  std::vector<std::size_t> record(std::uint64_t blocks) {
    const UniqueFd fd(::open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600));
    RecordingWriter writer(fd.get(), block_header());
    EXPECT_FALSE(writer.flush());
    std::vector<std::size_t> begins;
    for (std::uint64_t i = 0; i < blocks * kFramesOfBlock; ++i) {
      if (i % kFramesOfBlock == 0) begins.push_back(static_cast<std::size_t>(writer.bytes()));
      EXPECT_FALSE(writer.append(numbered_frame(i).slot));
      if (i % kFramesOfBlock == kFramesOfBlock - 1) {
        EXPECT_FALSE(writer.flush());
      }
    }
    begins.push_back(static_cast<std::size_t>(writer.bytes()));
    EXPECT_FALSE(writer.finish());
    return begins;
  }
  std::string bytes() const {
    std::ostringstream content;
    content << std::ifstream(path_, std::ios::binary).rdbuf();
    return content.str();
  }
  void write(const std::string& content) const { std::ofstream(path_, std::ios::binary) << content; }

  static ReadBack read(RecordingReader& reader) {
    ReadBack found;
    BlockFrame got;
    for (;;) {
      found.last = reader.next(got.slot);
      if (found.last == Status::end || found.last == Status::damaged) break;
      if (found.last == Status::skipped) ++found.skipped;
      if (found.last != Status::frame) continue;
      expect_as_recorded(got);
      found.frames.push_back(got.slot.sequence);
    }
    found.fault = reader.fault();
    EXPECT_EQ(found.skipped, reader.damaged_blocks());
    return found;
  }
  ReadBack read() const {
    RecordingReader reader(path_);
    return read(reader);
  }
  // Numbers of the frames of all blocks but some.
  static std::vector<std::uint64_t> frames_without(std::uint64_t blocks,
                                                   const std::vector<std::uint64_t>& damaged) {
    std::vector<std::uint64_t> frames;
    for (std::uint64_t i = 0; i < blocks * kFramesOfBlock; ++i) {
      if (std::find(damaged.begin(), damaged.end(), i / kFramesOfBlock) == damaged.end()) frames.push_back(i);
    }
    return frames;
  }

  testing::TempFolder folder_;
  UniqueFd file_{memfd_create("slipd-blocks", MFD_CLOEXEC)};  // thousands of files, which no disk has to take
  std::filesystem::path path_ = "/proc/self/fd/" + std::to_string(file_.get());
};

TEST_F(Blocks, OneDamagedIsLeftOutReportedAndCountedAndTheRestComes) {
  const auto begins = record(4);
  const auto whole = bytes();
  for (std::uint64_t block = 0; block < 4; ++block) {
    auto content = whole;
    content[begins[block] + 200] = static_cast<char>(content[begins[block] + 200] ^ 0x10);
    write(content);
    const ReadBack found = read();
    EXPECT_EQ(found.frames, frames_without(4, {block}));
    EXPECT_EQ(found.skipped, 1U);
    EXPECT_EQ(found.last, Status::end);
    EXPECT_THAT(found.fault, HasSubstr("byte " + std::to_string(begins[block]) +
                                       ": damaged; 1 block with 5 frames is left out"));
  }
}

TEST_F(Blocks, AnyByteThatChangesCostsAtMostItsBlockAndIsReported) {
  constexpr std::uint64_t kBlocks = 3;
  const auto begins = record(kBlocks);
  const auto whole = bytes();
  std::map<std::size_t, int> refused;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int mask : {0x01, 0x80, 0xFF}) {
      auto content = whole;
      content[at] = static_cast<char>(content[at] ^ mask);
      write(content);
      try {
        const ReadBack found = read();
        const auto block = static_cast<std::uint64_t>(std::upper_bound(begins.begin(), begins.end(), at) -
                                                      begins.begin() - 1);
        const bool in_block = at >= begins.front() && at < begins.back();
        EXPECT_EQ(found.frames, in_block ? frames_without(kBlocks, {block}) : frames_without(kBlocks, {}))
            << "byte " << at;
        // The last entry of the index only says where the index is, which is not needed to read on.
        if (at + 18 < whole.size()) {
          EXPECT_NE(found.fault, "") << "byte " << at;
        }
        EXPECT_EQ(found.last, Status::end);
      } catch (const RecordingError&) {
        ++refused[at];
      }
    }
  }
  EXPECT_THAT(refused, IsEmpty()) << "a damaged header is replaced by its copy in the index";
}

TEST_F(Blocks, SomeLostOrDoubledOrOfAnotherRecordingAreReportedAndNeverPlayed) {
  const auto begins = record(4);
  const auto whole = bytes();
  const auto block = [&](std::size_t i) { return whole.substr(begins[i], begins[i + 1] - begins[i]); };
  write(whole.substr(0, begins[1]) + whole.substr(begins[2]));
  EXPECT_EQ(read().frames, frames_without(4, {1}));
  EXPECT_EQ(read().skipped, 1U);
  EXPECT_THAT(read().fault, HasSubstr("5 frames"));
  write(whole.substr(0, begins[2]) + block(0) + whole.substr(begins[2]));
  EXPECT_EQ(read().frames, frames_without(4, {}));
  EXPECT_NE(read().fault, "");
  write(whole.substr(0, begins[1]) + std::string(100'000, '\x65') + whole.substr(begins[1]));
  EXPECT_EQ(read().frames, frames_without(4, {}));
  EXPECT_NE(read().fault, "");
  auto other_header = block_header();
  other_header.start_monotonic_ns = 999;
  const auto other = folder_.file("other.rec");
  {
    const UniqueFd fd(::open(other.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600));
    RecordingWriter writer(fd.get(), other_header);
    ASSERT_FALSE(writer.append(numbered_frame(77).slot));
  }
  std::ostringstream foreign;
  foreign << std::ifstream(other, std::ios::binary).rdbuf();
  write(whole.substr(0, begins[2]) + foreign.str() + whole.substr(begins[2]));
  EXPECT_EQ(read().frames, frames_without(4, {}));
  EXPECT_NE(read().fault, "");
}

TEST_F(Blocks, CutAnywherePlayToTheLastWholeOneAndSaySo) {
  const auto begins = record(3);
  const auto whole = bytes();
  for (std::size_t cut = begins.front(); cut < whole.size(); ++cut) {
    write(whole.substr(0, cut));
    const auto blocks =
        static_cast<std::uint64_t>(std::upper_bound(begins.begin(), begins.end(), cut) - begins.begin() - 1);
    const ReadBack found = read();
    EXPECT_EQ(found.frames, frames_without(blocks, {})) << "cut at " << cut;
    EXPECT_EQ(found.last, Status::end);
    EXPECT_THAT(found.fault, HasSubstr(cut == begins[blocks] ? "it was not finished" : "ends within"));
  }
}

TEST_F(Blocks, HoldWhatALongRecordingHoldsAndAreFoundByTime) {
  constexpr std::uint64_t kFrames = 20'000;  // in blocks of some 300
  {
    const UniqueFd fd(::open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600));
    RecordingWriter writer(fd.get(), block_header());
    for (std::uint64_t i = 0; i < kFrames; ++i) ASSERT_FALSE(writer.append(numbered_frame(i).slot));
    ASSERT_FALSE(writer.finish());
    EXPECT_EQ(writer.append(numbered_frame(0).slot), std::errc::invalid_argument);
    EXPECT_EQ(writer.bytes(), std::filesystem::file_size(path_));
  }
  RecordingReader reader(path_);
  EXPECT_EQ(reader.frames(), kFrames);
  EXPECT_EQ(read(reader).frames.size(), kFrames);
  EXPECT_EQ(reader.fault(), "");
  for (const std::uint64_t from : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{12'345}, kFrames - 1}) {
    ASSERT_TRUE(reader.seek(1'000'000 * static_cast<std::int64_t>(from)));
    const ReadBack found = read(reader);
    ASSERT_EQ(found.frames.size(), kFrames - from);
    EXPECT_EQ(found.frames.front(), from);
    EXPECT_EQ(found.fault, "");
  }
  reader.rewind();
  EXPECT_EQ(read(reader).frames.size(), kFrames);
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 1);
  EXPECT_FALSE(RecordingReader(path_).seek(5));
}

TEST_F(Blocks, AsManyAsADayHasKeepAnIndexOfLimitedSize) {
  constexpr std::uint64_t kBlocks = 5000;
  record(kBlocks);
  RecordingReader reader(path_);
  EXPECT_EQ(reader.frames(), kBlocks * kFramesOfBlock);
  ASSERT_TRUE(reader.seek(1'000'000 * std::int64_t{24'321}));
  EXPECT_EQ(read(reader).frames.front(), 24'321U);
}

TEST_F(Blocks, OfFramesLargerThanABlockHoldOneEach) {
  const auto layout = TaxelLayout::grid(100, 100, 0.000144);
  {
    const UniqueFd fd(::open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600));
    RecordingWriter writer(fd.get(), block_header(layout));
    for (std::uint64_t i = 0; i < 30; ++i) ASSERT_FALSE(writer.append(numbered_frame(i, layout.size()).slot));
  }
  RecordingReader reader(path_);
  BlockFrame got(layout.size());
  for (std::uint64_t i = 0; i < 30; ++i) {
    ASSERT_EQ(reader.next(got.slot), Status::frame);
    EXPECT_EQ(got.memory, numbered_frame(i, layout.size()).memory);
  }
  EXPECT_EQ(reader.next(got.slot), Status::end);
  EXPECT_EQ(reader.fault(), "");
}

// Made by slipd 0.1.0.
TEST_F(Blocks, ARecordingOfVersionOneStillPlays) {
  RecordingReader reader(std::filesystem::path(SLIPD_SOURCE_DIR) / "tests/data/recording-v1.rec");
  BlockFrame got(reader.header().layout.size());
  std::uint64_t frames = 0;
  while (reader.next(got.slot) == Status::frame) ++frames;
  EXPECT_EQ(reader.fault(), "");
  EXPECT_EQ(frames, 2U);
  EXPECT_EQ(got.memory.front(), 1000.0F);
  EXPECT_FALSE(reader.frames());
  reader.rewind();
  EXPECT_EQ(reader.next(got.slot), Status::frame);
}

class Outputs : public ::testing::Test {
 protected:
  void SetUp() override {
    std::array<int, 2> ends{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    reading_ = UniqueFd(ends[0]);
    writing_ = UniqueFd(ends[1]);
  }
  UniqueFd reading_, writing_;
  const std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(1'000'000);
};

// A reader that takes nothing ends a recording, and does not hold its writer up.
TEST_F(Outputs, ThatTakeNothingEndTheWriteInTime) {
  RecordingWriter writer(writing_.get(), block_header(), 0ms, OutputPatience{.stalled = 20ms});
  std::error_code error;
  for (std::uint64_t i = 0; !error; ++i) error = writer.append(numbered_frame(i).slot);
  EXPECT_EQ(error, std::errc::timed_out);
  EXPECT_EQ(writer.append(numbered_frame(0).slot), std::errc::timed_out);
  EXPECT_GT(unread_bytes(writing_.get()), 0U);
}

TEST_F(Outputs, ThatAreReadSlowlyGetAllOfIt) {
  std::string got;
  std::thread reader([&] {
    char piece[1000];
    for (ssize_t n = 0; (n = ::read(reading_.get(), piece, sizeof piece)) > 0;)
      got.append(piece, static_cast<std::size_t>(n));
  });
  std::uint64_t written = 0;
  {
    RecordingWriter writer(writing_.get(), block_header(), kRecordingFlush, OutputPatience{.stalled = 24h});
    for (std::uint64_t i = 0; i < 5000; ++i) ASSERT_FALSE(writer.append(numbered_frame(i).slot));
    ASSERT_FALSE(writer.finish());
    written = writer.bytes();
  }
  EXPECT_FALSE(await_read(writing_.get(), {.stalled = 24h}));
  EXPECT_EQ(unread_bytes(writing_.get()), 0U);
  writing_ = {};
  reader.join();
  EXPECT_EQ(got.size(), written);
}

TEST_F(Outputs, InAHurryAreWaitedForNoLonger) {
  const std::atomic<std::int64_t> now{std::chrono::steady_clock::now().time_since_epoch().count()};
  const OutputPatience patience{.stalled = 24h, .until_ns = &now};
  EXPECT_EQ(send_bounded(writing_.get(), bytes_, patience), std::errc::timed_out);
  EXPECT_EQ(await_read(writing_.get(), patience), std::errc::timed_out);
}

TEST_F(Outputs, ThatCloseUnreadAreNoticed) {
  const auto some = std::span(bytes_).first(10);
  ASSERT_FALSE(send_bounded(writing_.get(), some, {}));
  reading_ = {};
  EXPECT_EQ(await_read(writing_.get(), {.stalled = 24h}), std::errc::connection_reset);
  EXPECT_EQ(await_hang_up(writing_.get(), 24h), std::errc::connection_reset);
  EXPECT_EQ(unread_bytes(writing_.get()), 0U);
  EXPECT_EQ(send_bounded(writing_.get(), some, {}), std::errc::broken_pipe);
}

}  // namespace
}  // namespace slipd
