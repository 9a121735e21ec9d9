// The board in shared memory: its bytes, its seals, waiting on it, one writer and many readers.
#include "daemon/board/shared_board.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "clients/c/board_view.hpp"
#include "clients/c/slipd.h"
#include "tests/support/patience.hpp"

namespace slipd::testing {
namespace {

using client::BoardView;

class SharedBoardTest : public ::testing::Test {
 protected:
  void SetUp() override {
    board_.open({"left", "right"}, {"cup"});
    bool is_new = false;
    ASSERT_TRUE(writer_.begin_round(1234, is_new));
    EXPECT_TRUE(is_new);
    ASSERT_TRUE(writer_.begin_round(12345, is_new));
    EXPECT_FALSE(is_new);
    ASSERT_EQ(view_.map(board_.descriptor()), "");
  }
  static Estimate estimate_number(std::uint64_t number) {
    Estimate estimate;
    estimate.sequence = number;
    estimate.state = State::ok;
    estimate.time_ns = static_cast<std::int64_t>(number);
    estimate.published_ns = static_cast<std::int64_t>(number);
    estimate.gamma = static_cast<double>(number);
    estimate.sigma = static_cast<double>(number);
    estimate.normal_n = static_cast<double>(number);
    return estimate;
  }
  SharedBoard board_;
  SharedBoard::Writer writer_{board_};
  BoardView view_;
};

// As docs/clients.md has it for those who cannot link.
template <typename T>
T at(const std::byte* memory, std::size_t offset) {
  T value;
  std::memcpy(&value, memory + offset, sizeof value);
  return value;
}

TEST_F(SharedBoardTest, HasTheHeartbeatOfTheWriterThatIsFurthestBehind) {
  SharedBoard::Writer other(board_);
  bool is_new = false;
  writer_.begin_round(20000, is_new);
  EXPECT_EQ(view_.heartbeat_ns(), 0) << "the other has not written its records yet";
  other.begin_round(20001, is_new);
  EXPECT_TRUE(is_new);
  EXPECT_EQ(view_.heartbeat_ns(), 20000);
  writer_.begin_round(30000, is_new);
  writer_.begin_round(40000, is_new);
  EXPECT_EQ(view_.heartbeat_ns(), 20001);
}

TEST_F(SharedBoardTest, HasEachByteWhereThePageSays) {
  Estimate estimate = estimate_number(7);
  estimate.gamma = 0.25;
  estimate.sliding = Sliding::translation;
  estimate.alert = Alert::slip;
  estimate.alert_cause = AlertCause::sliding;
  estimate.health = Health::spike;
  writer_.publish_sensor(1, estimate, true);
  Estimate together = estimate_number(9);
  together.first_gamma = 0.125;
  writer_.publish_grasp(0, together, 5, false, 1);
  const UniqueFd file = board_.descriptor();
  void* const mapped = mmap(nullptr, board_.bytes(), PROT_READ, MAP_SHARED, file.get(), 0);
  ASSERT_NE(mapped, MAP_FAILED);
  const auto* const memory = static_cast<const std::byte*>(mapped);
  EXPECT_EQ(std::memcmp(memory, "slipdbrd", 8), 0);
  EXPECT_EQ(at<std::uint32_t>(memory, 8), 1U);
  const auto header = at<std::uint32_t>(memory, 12), slot = at<std::uint32_t>(memory, 16);
  EXPECT_EQ(header, 128U);
  EXPECT_EQ(slot, 704U);
  EXPECT_EQ(at<std::uint32_t>(memory, 20), 248U);
  EXPECT_EQ(at<std::uint32_t>(memory, 24), 2U);
  EXPECT_EQ(at<std::uint32_t>(memory, 28), 1U);
  EXPECT_EQ(at<std::uint64_t>(memory, 32), board_.generation());
  EXPECT_EQ(at<std::int64_t>(memory, 40), 20'000'000);
  EXPECT_EQ(at<std::int64_t>(memory, 64), 12345);
  EXPECT_EQ(at<std::uint32_t>(memory, 72), 0U);
  const std::byte* const right = memory + header + slot;
  EXPECT_STREQ(reinterpret_cast<const char*>(right), "right");
  EXPECT_EQ(at<std::uint32_t>(right, 68), 1U);
  const std::byte* const copy = right + 128 + std::size_t{256} * at<std::uint32_t>(right, 640);
  EXPECT_EQ(at<std::uint64_t>(copy, 0) % 2, 0U);
  const std::byte* const record = copy + 8;
  EXPECT_EQ(at<std::uint64_t>(record, 0), 7U);
  EXPECT_EQ(at<std::int64_t>(record, 8), 7);
  EXPECT_EQ(at<std::uint64_t>(record, 24), 1U);
  EXPECT_EQ(at<double>(record, 32), 0.25);
  EXPECT_TRUE(std::isnan(at<double>(record, 56)));
  EXPECT_EQ(at<double>(record, 72), 7);
  EXPECT_EQ(at<std::uint8_t>(record, 192), 0);
  EXPECT_EQ(at<std::uint8_t>(record, 193), 2);
  EXPECT_EQ(at<std::uint8_t>(record, 194), 2);
  EXPECT_EQ(at<std::uint8_t>(record, 196), 3);
  EXPECT_EQ(at<std::uint8_t>(record, 197), 2);
  EXPECT_EQ(at<std::uint8_t>(record, 198), 1);
  const std::byte* const cup = memory + header + std::size_t{2} * slot;
  EXPECT_STREQ(reinterpret_cast<const char*>(cup), "cup");
  EXPECT_EQ(at<std::uint32_t>(cup, 64), 1U);
  const std::byte* const grasp = cup + 128 + std::size_t{256} * at<std::uint32_t>(cup, 640) + 8;
  EXPECT_EQ(at<std::int64_t>(grasp, 8), 5);
  EXPECT_EQ(at<double>(grasp, 168), 0.125);
  EXPECT_EQ(at<std::uint32_t>(grasp, 200), 1U);
  munmap(mapped, board_.bytes());
}

TEST_F(SharedBoardTest, AMarginIsANumberInStateOkOnly) {
  for (int state = 0; state <= static_cast<int>(State::fault); ++state) {
    Estimate estimate = estimate_number(3);
    estimate.state = static_cast<State>(state);
    writer_.publish_sensor(0, estimate, false);
    EXPECT_EQ(std::isnan(view_.record(0).gamma), estimate.state != State::ok) << to_string(estimate.state);
  }
}

TEST_F(SharedBoardTest, BeforeTheFirstRecordASlotIsStale) {
  EXPECT_EQ(view_.record(2).state, SLIPD_STATE_STALE);
  EXPECT_TRUE(std::isnan(view_.record(2).gamma));
  EXPECT_EQ(view_.record(2).time_ns, 0);
}

// Seals hold however the receiver opens the file, also as its owner or as root.
TEST_F(SharedBoardTest, NoReceiverOfTheDescriptorCanChangeIt) {
  const UniqueFd passed = board_.descriptor();
  const auto size = static_cast<off_t>(board_.bytes());
  const auto attempts = [size](int file) {
    char byte = 'x';
    EXPECT_LT(pwrite(file, &byte, 1, 0), 0);
    EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0), MAP_FAILED);
    EXPECT_NE(ftruncate(file, 0), 0);
    EXPECT_NE(ftruncate(file, size + 4096), 0);
    EXPECT_NE(fallocate(file, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096), 0);
    EXPECT_NE(fcntl(file, F_ADD_SEALS, F_SEAL_WRITE), 0);
    void* const readable = mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0);
    ASSERT_NE(readable, MAP_FAILED);
    EXPECT_NE(mprotect(readable, 4096, PROT_READ | PROT_WRITE), 0);
    munmap(readable, 4096);
  };
  attempts(passed.get());
  const UniqueFd again(open(("/proc/self/fd/" + std::to_string(passed.get())).c_str(), O_RDWR | O_CLOEXEC));
  ASSERT_TRUE(again) << "this is why a descriptor reopened for reading would not be enough";
  attempts(again.get());
  writer_.publish_sensor(0, estimate_number(1), false);
  EXPECT_EQ(view_.record(0).sequence, 1U);
}

TEST_F(SharedBoardTest, ReadersFindWholeRecordsInTheirOrder) {
  constexpr std::uint64_t kRecords = 20'000;
  std::vector<std::jthread> readers;
  std::atomic<int> reading{0};
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      BoardView view;
      ASSERT_EQ(view.map(board_.descriptor()), "");
      ++reading;
      std::uint64_t last = 0;
      while (last < kRecords) {
        const auto record = view.record(0);
        if (record.number == 0) continue;
        ASSERT_EQ(record.gamma, static_cast<double>(record.sequence));
        ASSERT_EQ(record.normal_n, static_cast<double>(record.sequence));
        ASSERT_EQ(record.number, record.sequence);
        ASSERT_GE(record.sequence, last);
        last = record.sequence;
      }
    });
  }
  while (reading < 3) std::this_thread::yield();
  for (std::uint64_t i = 1; i <= kRecords; ++i) writer_.publish_sensor(0, estimate_number(i), false);
}

// The kernel lets a reader sleep on a word that it cannot write.
TEST_F(SharedBoardTest, AReaderOfReadOnlyMemoryIsWoken) {
  const auto attachment = board_.wait_for({0});
  std::atomic<std::uint64_t> got{0};
  std::jthread reader([&] {
    for (std::uint64_t last = 0; last < 100;) {
      const std::uint32_t seen = view_.published(0);
      const auto record = view_.record(0);
      if (record.number > last) {
        last = record.number;
        got = last;
        continue;
      }
      timespec until{};
      clock_gettime(CLOCK_MONOTONIC, &until);
      until.tv_sec += std::chrono::seconds(kPatience).count();
      const auto* const word =
          &reinterpret_cast<const board_layout::Slot*>(reinterpret_cast<const std::byte*>(view_.name(0)))
               ->published;
      const auto waited =
          syscall(SYS_futex, word, FUTEX_WAIT_BITSET, seen, &until, nullptr, FUTEX_BITSET_MATCH_ANY);
      ASSERT_TRUE(waited == 0 || errno == EAGAIN || errno == EINTR) << std::strerror(errno);
    }
  });
  for (std::uint64_t i = 1; i <= 100; ++i) {
    writer_.publish_sensor(0, estimate_number(i), false);
    while (got < i) std::this_thread::yield();
  }
}

TEST_F(SharedBoardTest, MoreReadersThanTheWriterWakesAreLeftToIo) {
  std::vector<SharedBoard::Attachment> attached;
  for (std::uint32_t i = 0; i < SharedBoard::kWokenDirectly; ++i) attached.push_back(board_.wait_for({0}));
  EXPECT_FALSE(writer_.publish_sensor(0, estimate_number(1), false));
  attached.push_back(board_.wait_for({0}));
  EXPECT_TRUE(writer_.publish_sensor(0, estimate_number(2), false));
  EXPECT_FALSE(writer_.publish_sensor(1, estimate_number(2), false)) << "nobody waits for it";
  board_.wake_others();
  attached.pop_back();
  EXPECT_FALSE(writer_.publish_sensor(0, estimate_number(3), false));
}

TEST_F(SharedBoardTest, WhenItIsClosedItsReadersWake) {
  std::jthread reader([&] {
    while (!view_.closed()) view_.wait(1, view_.published(1), std::numeric_limits<std::int64_t>::max());
  });
  board_.close();
}

}  // namespace
}  // namespace slipd::testing
