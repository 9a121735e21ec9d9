// slipd's real-time threads allocate and free nothing once they run. The test runs the real program with
// every allocation function replaced by one that counts.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <new>

#include "tests/support/allocation_guard.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

class SharedCounts {
 public:
  explicit SharedCounts(const std::filesystem::path& file) {
    const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (ftruncate(fd, sizeof(AllocationCounts)) != 0) throw std::runtime_error("ftruncate");
    void* const memory = mmap(nullptr, sizeof(AllocationCounts), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    counts_ = new (memory) AllocationCounts;
  }
  ~SharedCounts() { munmap(counts_, sizeof(AllocationCounts)); }
  SharedCounts(const SharedCounts&) = delete;
  SharedCounts& operator=(const SharedCounts&) = delete;
  AllocationCounts* operator->() { return counts_; }

 private:
  AllocationCounts* counts_;
};

std::uint64_t estimated(const json& status) {
  std::uint64_t least = UINT64_MAX;
  for (const json& sensor : status["sensors"])
    least = std::min(least, sensor["estimated"].get<std::uint64_t>());
  return least;
}

// Runs slipd until each of its sensors has some estimates, arms the guard, and waits for a thousand more
// while clients send every kind of request. Returns an upper bound of the estimates made while the guard was
// armed.
std::uint64_t watch(const json& sensors, const std::filesystem::path& drivers, SharedCounts& counts,
                    const TempFolder& folder, json more = {{"estimator", {{"method", "moments"}}}}) {
  Daemon daemon(config_with(folder, sensors, more), drivers,
                {{"LD_PRELOAD", std::string(SLIPD_BINARY_DIR) + "/test-bin/libslipd-allocation-guard.so"},
                 {kAllocationGuardFile, folder.file("counts").string()},
                 {"STATE_DIRECTORY", folder.path().string()}});
  const auto begin = estimated(daemon.wait_for("status", [](const json& s) { return estimated(s) >= 20; }));
  counts->armed = true;
  auto client = daemon.client();
  client.result("subscribe");
  client.result("attach");
  const std::string name = sensors[0]["name"];
  EXPECT_TRUE(client.record(name, 0.1, folder.file("recording")).contains("frames"));
  daemon.wait_for("status", [&](const json& s) {
    client.result("frame", {{"sensor", name}});
    return estimated(s) >= begin + 1000;
  });
  counts->armed = false;
  return estimated(client.result("status")) - begin;
}

TEST(Allocation, NoneInTheThreadsOfFramesAndEstimates) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer has replaced the allocator already";
  const TempFolder folder;
  SharedCounts counts(folder.file("counts"));
  watch({{{"name", "left"}, {"driver", "trial"}, {"options", {{"gap_every", 3}, {"corrupt_every", 5}}}},
         {{"name", "right"}, {"driver", "trial"}, {"layout", {{"grid", {4, 4}}, {"pitch_mm", 4}}}}},
        trial_drivers(), counts, folder);
  EXPECT_EQ(counts->acquire, 0U);
  EXPECT_EQ(counts->estimate, 0U);
  EXPECT_GT(counts->others, 0U) << "the guard must have counted something";
}

// The interface does not exist, and the thread looks for it again and again. tests/vm/guest/can_output.sh
// tests an interface that exists and fails.
TEST(Allocation, NoneInTheThreadOfTheBus) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer has replaced the allocator already";
  const TempFolder folder;
  SharedCounts counts(folder.file("counts"));
  const json sensor{{"driver", "trial"}, {"options", {{"gamma", 0.1}}}};
  json left(sensor), right(sensor);
  left["name"] = "left";
  right["name"] = "right";
  watch({left, right}, trial_drivers(), counts, folder,
        {{"estimator", {{"method", "moments"}}},
         {"grasps", {{{"name", "both"}, {"sensors", {"left", "right"}}}}},
         {"can", {{"interface", "nowhere0"}, {"allow_simulated", true}}}});
  EXPECT_EQ(counts->can, 0U);
  EXPECT_EQ(counts->estimate, 0U);
  EXPECT_GT(counts->others, 0U);
}

// The bias is updated every hundred milliseconds; the thousand frames take a second.
TEST(Allocation, NoneForASensorWhoseZeroIsTakenAndFollowed) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer has replaced the allocator already";
  const TempFolder folder;
  SharedCounts counts(folder.file("counts"));
  const json options{
      {"zeroed", false}, {"drift_kpa_s", 0.01}, {"cycle", {{{"ms", 3600000}, {"normal_n", 0}}}}};
  watch(json::array({{{"name", "left"},
                      {"driver", "sim"},
                      {"gain", 1.5},
                      {"layout", {{"grid", {12, 12}}, {"pitch_mm", 1.2}}},
                      {"options", options}}}),
        real_drivers(), counts, folder);
  EXPECT_EQ(counts->acquire, 0U);
  EXPECT_EQ(counts->estimate, 0U);
}

// FLANN's exact search allocates and frees a list of visited nodes for each query. slipd's own code adds no
// allocation.
TEST(Allocation, OfNearestNeighboursOnlyTheOneInsideFlann) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer has replaced the allocator already";
  const TempFolder folder;
  SharedCounts counts(folder.file("counts"));
  const json layout{{"grid", {12, 12}}, {"pitch_mm", 1.2}};
  const auto frames = watch(json::array({{{"name", "left"}, {"driver", "sim"}, {"layout", layout}}}),
                            real_drivers(), counts, folder, {{"estimator", {{"method", "svd-knn"}}}});
  EXPECT_EQ(counts->acquire, 0U);
  EXPECT_LE(counts->estimate, 2 * frames);
}

TEST(Allocation, TheGuardSeesADriverThatAllocates) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer has replaced the allocator already";
  const TempFolder folder;
  SharedCounts counts(folder.file("counts"));
  watch({{{"name", "left"}, {"driver", "trial"}, {"options", {{"behaviour", "allocate"}}}}}, trial_drivers(),
        counts, folder);
  EXPECT_GT(counts->acquire, 0U);
  EXPECT_EQ(counts->estimate, 0U);
}

}  // namespace
}  // namespace slipd::testing
