// Reading frames allocates nothing, from the first frame on, with every option.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <new>

#include "core/recording/recording.hpp"
#include "drivers/replay/replay_driver.hpp"
#include "drivers/sim/sim_driver.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

using test::allocations;
using test::OwnedSlot;
using test::setup_of;

// Reads so many frames; says how often that allocated.
std::uint64_t allocations_of(DeviceDriver& driver, std::size_t taxels, int frames) {
  driver.open();
  OwnedSlot slot(taxels);
  const auto before = allocations();
  while (frames > 0) {
    const auto result = driver.read({&slot.slot, 1}, std::chrono::seconds(5));
    if (result.status == ReadStatus::frame) --frames;
    if (result.status == ReadStatus::end || result.status == ReadStatus::disconnected) break;
  }
  return allocations() - before;
}

class ReadingAllocatesNothing : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("slipd-hot-path-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(ReadingAllocatesNothing, AndTheCounterCounts) {
  const auto before = allocations();
  ::operator delete(::operator new(1));  // a call, which unlike a new-expression is not optimised away
  EXPECT_EQ(allocations() - before, 1U);
}

TEST_F(ReadingAllocatesNothing, InTheSimulatedSensorThroughAWholeCycleWithFaults) {
  nlohmann::json options = {{"noise", 0.01},
                            {"drop", 0.1},
                            {"late_ms", 0.1},
                            {"dead", 0.1},
                            {"gain_spread", 0.1},
                            {"drift_kpa_s", 1},
                            {"grip_input", folder_ / "grip"}};
  options["cycle"] = {{{"ms", 20}, {"normal_n", {0, 3}}, {"shear_n", 0}, {"friction", 0.5}},
                      {{"ms", 20}, {"load", {0, 1.1}}},
                      {{"ms", 20}, {"normal_n", {3, 5}}},
                      {{"ms", 20}, {"shear_n", {1.5, -1}}},
                      {{"ms", 20}, {"friction", 0.2}, {"normal_n", {5, 0}}}};
  sim::SimDriver driver({setup_of(TaxelLayout::grid(16, 16, 0.001), options, 5000)});
  EXPECT_EQ(allocations_of(driver, 256, 1200), 0U);
}

TEST_F(ReadingAllocatesNothing, InReplaysOverFilesOfBothKinds) {
  const auto layout = TaxelLayout::grid(2, 1, 0.004);
  const int fd = ::open((folder_ / "b.cbor").c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  {
    RecordingWriter writer(fd, {"left", SensorClass::array3, layout, 1000, false, 1, 1, ""});
    OwnedSlot slot(2);
    const auto before = allocations();
    for (int i = 0; i < 20000; ++i) {
      ++slot.slot.sequence;
      slot.slot.time_ns += 1000000;
      EXPECT_FALSE(writer.append(slot.slot));
    }
    EXPECT_EQ(allocations() - before, 0U);
  }
  ::close(fd);
  {
    std::ofstream csv(folder_ / "a.csv");
    csv << "txl1_x,txl1_y,txl1_z,txl2_x,txl2_y,txl2_z,time\n";
    for (int i = 0; i < 5000; ++i) csv << "1.5,-2,3e4,4,5,6," << 0.001 * i << "\n";
  }
  replay::ReplayDriver driver({setup_of(layout, {{"file", folder_}, {"speed", 0}, {"loop", true}})});
  EXPECT_EQ(allocations_of(driver, 2, 60000), 0U);
}

}  // namespace
}  // namespace slipd
