// The driver push and its shared memory, against a program that maps it by the page's bytes alone: frames
// that are whole, torn, foreign, and a writer that does what it likes meanwhile.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <memory>
#include <string>

#include "drivers/pacing.hpp"
#include "drivers/push/push_driver.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/push_writer.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::test {
namespace {

using namespace std::chrono_literals;
using push_layout::Answer;
using testing::PushWriter;

constexpr std::size_t kRingSide = 40;
constexpr std::size_t kRingTaxels = kRingSide * kRingSide;
constexpr std::size_t kRingValues = 3 * kRingTaxels;
// As docs/push.md has it.
constexpr std::size_t kAtTaken = 64, kAtSlots = 128, kSlotHead = 64, kSlots = 4;
constexpr std::size_t kSlotBytes = kSlotHead + 4 * kRingValues;

// A program with the memory that it was given.
class RingWriter {
 public:
  RingWriter(const std::filesystem::path& path, push::PushDriver& driver, std::span<FrameSlot> slots)
      : socket_(path) {
    socket_.hello({.unit = push_layout::Unit::pascal, .taxels = kRingTaxels});
    driver.read(slots, 20ms);
    EXPECT_EQ(socket_.answer(MSG_DONTWAIT).code, Answer::accepted);
    struct stat there {};
    EXPECT_EQ(::fstat(socket_.ring(), &there), 0);
    bytes_ = static_cast<std::size_t>(there.st_size);
    EXPECT_EQ(bytes_, kAtSlots + kSlots * kSlotBytes);
    memory_ =
        static_cast<char*>(::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, socket_.ring(), 0));
    EXPECT_NE(memory_, MAP_FAILED);
  }
  ~RingWriter() { ::munmap(memory_, bytes_); }
  RingWriter(const RingWriter&) = delete;
  RingWriter& operator=(const RingWriter&) = delete;

  std::atomic<std::uint64_t>& word(std::size_t at) {
    return *reinterpret_cast<std::atomic<std::uint64_t>*>(memory_ + at);
  }
  std::uint64_t taken() { return word(kAtTaken).load(); }
  std::atomic<std::uint64_t>& number(std::uint64_t frame) {
    return word(kAtSlots + frame % kSlots * kSlotBytes);
  }
  void fill(std::uint64_t frame, const std::vector<float>& values) {
    std::memcpy(memory_ + kAtSlots + frame % kSlots * kSlotBytes + kSlotHead, values.data(),
                4 * values.size());
  }
  bool notify(std::uint64_t frame, push_layout::FrameHead head) {
    head.flags |= push_layout::kInRing;
    if (head.size == 0) head.size = sizeof(push_layout::Notice);
    const push_layout::Notice notice{head, frame};
    return socket_.send(&notice, sizeof notice, MSG_DONTWAIT);
  }
  bool push(std::uint64_t frame, const std::vector<float>& values) {
    fill(frame, values);
    number(frame) = frame;
    return notify(frame, {.sequence = frame});
  }
  PushWriter& socket() { return socket_; }
  char* memory() { return memory_; }

 private:
  PushWriter socket_;
  std::size_t bytes_ = 0;
  char* memory_ = nullptr;
};

class PushRing : public ::testing::Test {
 protected:
  PushRing()
      : driver_({setup_of(TaxelLayout::grid(kRingSide, kRingSide, 0.001),
                          {{"path", path_.string()}, {"max_age_ms", 10'000}}, 1000)}) {
    driver_.open();
  }
  ReadStatus read() { return driver_.read(slots_, 20ms).status; }

  testing::TempFolder folder_;
  std::filesystem::path path_ = folder_.file("left");
  push::PushDriver driver_;
  OwnedSlot owned_{kRingTaxels};
  std::array<FrameSlot, 1> slots_{owned_.slot};
};

TEST_F(PushRing, FramesComeByIt) {
  RingWriter writer(path_, driver_, slots_);
  std::vector<float> values(kRingValues);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  for (std::uint64_t frame = 1; frame <= 3 * kSlots; ++frame) {
    values[2] = static_cast<float>(frame);
    ASSERT_TRUE(writer.push(frame, values));
    ASSERT_EQ(read(), ReadStatus::frame);
    EXPECT_EQ(owned_.slot.normal_pa[0], values[2]);
    EXPECT_EQ(owned_.slot.shear_x_pa[7], values[21]);
    EXPECT_EQ(owned_.slot.shear_y_pa.back(), values[kRingValues - 2]);
    EXPECT_EQ(writer.taken(), frame) << "its slot is free";
    EXPECT_EQ(slots_[0].sequence, frame);
  }
}

TEST_F(PushRing, WholeFramesMayComeByTheSocketInBetween) {
  RingWriter writer(path_, driver_, slots_);
  const std::vector<float> ones(kRingValues, 1), twos(kRingValues, 2);
  ASSERT_TRUE(writer.push(1, ones));
  ASSERT_TRUE(writer.socket().push(twos, {.sequence = 2, .time_ns = monotonic_ns()}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "another one waits, so it is not of now";
  EXPECT_EQ(writer.taken(), 1U) << "a frame that is not used is given back, too";
  ASSERT_EQ(read(), ReadStatus::frame);
  EXPECT_EQ(owned_.slot.normal_pa[0], 2);
}

TEST_F(PushRing, WhatIsNotWholeIsCountedAndTheNextFrameIsTaken) {
  RingWriter writer(path_, driver_, slots_);
  const std::vector<float> values(kRingValues, 1);
  std::vector<float> odd = values;
  odd[kRingValues / 2] = std::numeric_limits<float>::infinity();
  writer.fill(1, values);
  EXPECT_TRUE(writer.notify(1, {.sequence = 1}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "a slot without a number: it is being written";
  EXPECT_THAT(driver_.why_no_frames(), ::testing::HasSubstr("in shared memory that were not whole"));
  writer.number(1) = 5;
  EXPECT_TRUE(writer.notify(1, {.sequence = 1}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "a slot that holds another frame";
  writer.number(0) = 0;
  EXPECT_TRUE(writer.notify(0, {.sequence = 1}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "frame 0, as the memory was when it was made";
  writer.number(~0ULL) = 1;
  EXPECT_TRUE(writer.notify(~0ULL, {.sequence = 1}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "a frame far ahead";
  writer.number(1) = 1;
  EXPECT_TRUE(writer.notify(1, {.size = 24 + 4 * kRingValues, .sequence = 1}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "a size that is not the notice's";
  EXPECT_TRUE(writer.notify(1, {.flags = push_layout::kBad, .sequence = 1}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "marked as bad";
  EXPECT_TRUE(writer.push(2, odd));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "a value that is not finite";
  EXPECT_TRUE(writer.socket().push(values, {.flags = push_layout::kInRing, .sequence = 3}));
  EXPECT_EQ(read(), ReadStatus::corrupt) << "a whole frame that says it is in the ring";
  EXPECT_TRUE(writer.push(3, values));
  EXPECT_EQ(read(), ReadStatus::frame);
}

// A writer that overwrites a slot while slipd is amid its values: slipd's first touch of the page in the
// middle is caught, and the writer goes on there.
class Ambush {
 public:
  explicit Ambush(RingWriter& writer) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      auto* const begin = reinterpret_cast<char*>(std::stoull(line, nullptr, 16));
      if (line.find("memfd:slipd-push") != std::string::npos && begin != writer.memory()) theirs_ = begin;
    }
    EXPECT_NE(theirs_, nullptr) << "slipd's mapping";
    writer_ = &writer;
    struct sigaction caught {};
    caught.sa_handler = [](int) { overwrite(); };
    ::sigaction(SIGSEGV, &caught, &before_);
    EXPECT_EQ(::mprotect(page(), kPage, PROT_NONE), 0);
  }
  ~Ambush() { ::sigaction(SIGSEGV, &before_, nullptr); }
  Ambush(const Ambush&) = delete;
  Ambush& operator=(const Ambush&) = delete;

  static inline int sprung = 0;

 private:
  static constexpr std::size_t kPage = 4096;

  // In the middle of the slot of frame 1.
  static char* page() { return theirs_ + (kAtSlots + kSlotBytes + kSlotBytes / 2) / kPage * kPage; }

  static void overwrite() {
    ++sprung;
    writer_->number(1).exchange(0);
    std::memset(writer_->memory() + kAtSlots + kSlotBytes + kSlotHead, 0, 4 * kRingValues);
    ::mprotect(page(), kPage, PROT_READ | PROT_WRITE);
  }

  static inline char* theirs_ = nullptr;
  static inline RingWriter* writer_ = nullptr;
  struct sigaction before_ {};
};

TEST_F(PushRing, AFrameThatIsOverwrittenWhileItIsReadIsNeverTakenForOne) {
  RingWriter writer(path_, driver_, slots_);
  const std::vector<float> values(kRingValues, 1);
  ASSERT_TRUE(writer.push(1, values));
  {
    const Ambush ambush(writer);
    EXPECT_EQ(read(), ReadStatus::corrupt);
    EXPECT_EQ(Ambush::sprung, 1);
  }
  EXPECT_EQ(owned_.slot.normal_pa.front(), 1) << "slipd had begun";
  EXPECT_EQ(owned_.slot.normal_pa.back(), 0) << "and it was torn";
  ASSERT_TRUE(writer.push(2, values));
  EXPECT_EQ(read(), ReadStatus::frame);
}

TEST_F(PushRing, AWriterCanNeitherShrinkNorGrowIt) {
  RingWriter writer(path_, driver_, slots_);
  EXPECT_NE(::ftruncate(writer.socket().ring(), 0), 0);
  EXPECT_NE(::ftruncate(writer.socket().ring(), 1 << 24), 0);
  EXPECT_NE(::fcntl(writer.socket().ring(), F_ADD_SEALS, F_SEAL_WRITE), 0);
  // Holes read as zeros: a frame without a number.
  ASSERT_TRUE(writer.push(1, std::vector<float>(kRingValues, 1)));
  ASSERT_EQ(::fallocate(writer.socket().ring(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
                        kAtSlots + kSlots * kSlotBytes),
            0);
  EXPECT_EQ(read(), ReadStatus::corrupt);
  EXPECT_TRUE(writer.push(2, std::vector<float>(kRingValues, 1)));
  EXPECT_EQ(read(), ReadStatus::frame);
}

TEST_F(PushRing, AWriterThatFillsItsHeadWithNonsenseChangesNothing) {
  RingWriter writer(path_, driver_, slots_);
  std::memset(writer.memory(), 0xFF, kAtSlots);
  EXPECT_TRUE(writer.push(1, std::vector<float>(kRingValues, 1)));
  EXPECT_EQ(read(), ReadStatus::frame);
}

TEST_F(PushRing, ANextWriterHasMemoryThatTheOneBeforeDoesNotReach) {
  auto first = std::make_unique<RingWriter>(path_, driver_, slots_);
  const int kept = ::dup(first->socket().ring());
  ASSERT_TRUE(first->push(1, std::vector<float>(kRingValues, 1)));
  ASSERT_EQ(read(), ReadStatus::frame);
  first.reset();
  RingWriter second(path_, driver_, slots_);
  struct stat before {
  }, now{};
  ASSERT_EQ(::fstat(kept, &before), 0);
  ASSERT_EQ(::fstat(second.socket().ring(), &now), 0);
  EXPECT_NE(before.st_ino, now.st_ino);
  ::close(kept);
  EXPECT_EQ(second.number(1), 0U);
  EXPECT_TRUE(second.push(1, std::vector<float>(kRingValues, 2)));
  EXPECT_EQ(read(), ReadStatus::frame);
}

TEST_F(PushRing, SmallFramesHaveNone) {
  push::PushDriver small(
      {setup_of(TaxelLayout::grid(2, 2, 0.001), {{"path", folder_.file("small").string()}})});
  small.open();
  PushWriter writer(folder_.file("small"));
  writer.hello({.unit = push_layout::Unit::pascal, .taxels = 4});
  OwnedSlot owned(4);
  std::array slots{owned.slot};
  small.read(slots, 20ms);
  EXPECT_EQ(writer.answer(MSG_DONTWAIT).code, Answer::accepted);
  EXPECT_LT(writer.ring(), 0);
}

TEST_F(PushRing, ReadingAllocatesNothing) {
  const auto allocated = [&] {
    const std::uint64_t before = allocations();
    read();
    return allocations() - before;
  };
  {
    PushWriter first(path_);
    first.hello({.unit = push_layout::Unit::pascal, .taxels = kRingTaxels});
    EXPECT_EQ(allocated(), 0) << "an acceptance";
  }
  RingWriter writer(path_, driver_, slots_);
  writer.push(1, std::vector<float>(kRingValues, 1));
  EXPECT_EQ(allocated(), 0) << "a frame";
  writer.notify(2, {.sequence = 2});
  EXPECT_EQ(allocated(), 0) << "a torn one";
}

}  // namespace
}  // namespace slipd::test
