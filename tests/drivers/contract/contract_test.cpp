// The driver contract, checked for every driver. The device's values are constant, so that a frame which
// differs from the others was assembled from parts of different scans.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "tests/drivers/contract/test_rig.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kTimeout = 20ms;
constexpr auto kPatience = 5min;  // for what must come; only what hangs takes that long

class DriverContract : public testing::TestWithParam<DriverCase> {
 protected:
  void open() {
    const DeviceInfo info = rig_->driver().open();
    if (owned_.empty()) {
      for (const SensorInfo& sensor : info.sensors) owned_.emplace_back(sensor.layout.size());
      for (OwnedSlot& owned : owned_) slots_.push_back(owned.slot);
    }
    ASSERT_EQ(info.sensors.size(), slots_.size());
    last_.clear();
    settle();
  }

  // One read, held to what holds for every read.
  ReadResult read() {
    const auto begun = Clock::now();
    const ReadResult result = rig_->driver().read(slots_, kTimeout);
    EXPECT_LT(result.sensor, slots_.size());
    if (result.status == ReadStatus::timeout) {
      EXPECT_GE(Clock::now() - begun, kTimeout) << "a time-out before the time is out";
    }
    if (result.status == ReadStatus::frame) look_at(result.sensor);
    return result;
  }

  void look_at(std::uint16_t sensor) {
    const FrameSlot& slot = slots_[sensor];
    const auto before = last_.find(sensor);
    if (before != last_.end()) {
      EXPECT_GT(slot.sequence, before->second) << "the sequence does not rise";
      lost_ += slot.sequence - before->second - 1;
    }
    last_[sensor] = slot.sequence;
    const std::vector<float>& now = owned_[sensor].memory;
    for (const float value : now) ASSERT_TRUE(std::isfinite(value));
    if (garbled_) return;
    auto& wanted = wanted_[sensor];
    if (wanted.empty()) wanted = now;
    EXPECT_EQ(now, wanted) << "a frame of parts that do not belong together";
  }

  // Reads until `count` frames have come. False: they did not, or the device is gone.
  bool frames(int count) {
    const auto give_up = Clock::now() + kPatience;
    while (count > 0 && Clock::now() < give_up) {
      const ReadStatus status = read().status;
      if (status == ReadStatus::disconnected || status == ReadStatus::end) return false;
      count -= status == ReadStatus::frame ? 1 : 0;
    }
    return count == 0;
  }

  bool sees(ReadStatus wanted) {
    const auto give_up = Clock::now() + kPatience;
    while (Clock::now() < give_up) {
      if (read().status == wanted) return true;
    }
    return false;
  }

  // A device that is asked has nothing to say before its first scan: its registers are 0.
  void settle() {
    const auto zero = [](float value) { return value == 0; };
    const auto blank = [&](const OwnedSlot& owned) { return std::ranges::all_of(owned.memory, zero); };
    garbled_ = true;
    const auto give_up = Clock::now() + kPatience;
    while (std::ranges::any_of(owned_, blank) && Clock::now() < give_up) read();
    garbled_ = false;
  }

  std::unique_ptr<TestRig> rig_ = GetParam().make();
  std::vector<OwnedSlot> owned_;
  std::vector<FrameSlot> slots_;
  std::map<std::uint16_t, std::uint64_t> last_;  // sequence of each sensor's last frame
  std::map<std::uint16_t, std::vector<float>> wanted_;
  std::uint64_t lost_ = 0;
  bool garbled_ = false;
};

TEST_P(DriverContract, OpensAndClosesAgainAndAgain) {
  rig_->driver().close();
  open();
  EXPECT_TRUE(frames(3));
  rig_->driver().close();
  rig_->driver().close();
  open();
  EXPECT_TRUE(frames(3));
  open();
  EXPECT_TRUE(frames(3));
  rig_->driver().close();
}

TEST_P(DriverContract, DescribesAllSensorsOfTheDevice) {
  open();
  const auto give_up = Clock::now() + kPatience;
  while (last_.size() < slots_.size() && Clock::now() < give_up) read();
  EXPECT_EQ(last_.size(), slots_.size());
}

TEST_P(DriverContract, SurvivesAnyBytesAndDropsWholeScans) {
  if (!GetParam().misbehaves) GTEST_SKIP() << "there is no device";
  open();
  ASSERT_TRUE(frames(5));
  for (const char* order : {"lose", "reorder", "repeat", "shorten", "lengthen"}) {
    rig_->order(std::string(order) + " 5");
    EXPECT_TRUE(frames(20)) << order;
  }
  garbled_ = true;  // what has the right length and no checksum is a frame
  rig_->order("garbage 5");
  EXPECT_TRUE(frames(20)) << "garbage";
  garbled_ = false;
  EXPECT_TRUE(frames(10)) << "after garbage";
}

TEST_P(DriverContract, CountsWhatIsLost) {
  if (!GetParam().misbehaves || !GetParam().knows_losses) GTEST_SKIP() << "not on this bus";
  open();
  ASSERT_TRUE(frames(5));
  lost_ = 0;
  rig_->order("lose 5");
  const auto give_up = Clock::now() + kPatience;
  while (lost_ < 5 && Clock::now() < give_up) read();
  EXPECT_GE(lost_, 5);
}

TEST_P(DriverContract, WaitsForADeviceThatStalls) {
  if (!GetParam().misbehaves) GTEST_SKIP() << "there is no device";
  open();
  rig_->order("stall 100");
  ASSERT_TRUE(sees(ReadStatus::timeout));
  EXPECT_TRUE(frames(5));
}

TEST_P(DriverContract, SaysWhenTheDeviceIsGoneAndOpensItAgainWhenItIsBack) {
  if (!GetParam().misbehaves) GTEST_SKIP() << "there is no device";
  open();
  rig_->order("unplug");
  if (!GetParam().sees_unplugging) {
    ASSERT_TRUE(sees(ReadStatus::timeout));
    rig_->order("plug");
    EXPECT_TRUE(frames(5)) << "without being opened again";
    return;
  }
  ASSERT_TRUE(sees(ReadStatus::disconnected));
  rig_->driver().close();
  EXPECT_NE(refusal_of([&] { rig_->driver().open(); }), "");
  rig_->order("plug");
  const auto give_up = Clock::now() + kPatience;
  while (!refusal_of([&] { rig_->driver().open(); }).empty() && Clock::now() < give_up) {
  }
  last_.clear();
  EXPECT_TRUE(frames(5));
}

TEST_P(DriverContract, AllocatesNothingWhileReading) {
  open();
  ASSERT_TRUE(frames(5));
  rig_->order("lose 2");
  std::uint64_t allocated = 0;
  for (int i = 0; i < 50; ++i) {
    const std::uint64_t before = allocations();
    rig_->driver().read(slots_, kTimeout);
    allocated += allocations() - before;
  }
  EXPECT_EQ(allocated, 0);
}

std::ptrdiff_t descriptors() {
  namespace fs = std::filesystem;
  return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
}

TEST_P(DriverContract, LeaksNeitherDescriptorsNorMemoryOverAThousandOpenings) {
  const auto reopen = [&](int times) {
    for (int i = 0; i < times; ++i) {
      rig_->driver().open();
      rig_->driver().read(slots_, 0us);
      rig_->driver().close();
    }
    open();
    EXPECT_TRUE(frames(5)) << "and by then the device has heard all";
    rig_->driver().close();
  };
  open();
  reopen(20);
  const std::ptrdiff_t before = descriptors();
  const std::size_t bytes_before = ::mallinfo2().uordblks;
  reopen(1000);
  EXPECT_LE(descriptors(), before + 2)
      << "the device's end of the last line may be open yet, or closed by then";
  // A thousand leaks of the smallest driver_case are 32 kB; what libraries and the device's thread hold goes
  // up and down.
  EXPECT_LT(::mallinfo2().uordblks, bytes_before + 24'000);
}

INSTANTIATE_TEST_SUITE_P(Drivers, DriverContract, testing::ValuesIn(all_driver_cases()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace slipd::test
