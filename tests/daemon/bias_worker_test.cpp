// A bias between three threads: the one that measures it, the one that writes it and the one that requests
// it.
#include "daemon/pipeline/bias_worker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "daemon/pipeline/bias_store.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd {
namespace {

const SensorInfo kInfo{.layout = TaxelLayout::grid(3, 2, 0.002)};
const BiasIdentity kSensor{"trial", "", "{}", "left", 6};

// The acquire thread of a sensor that reads `offset` everywhere, without pacing; frames are 10 ms apart.
class Acquiring {
 public:
  Acquiring(BiasWorker& worker, const std::atomic<float>& offset)
      : thread_([&](const std::stop_token& stop) {
          std::vector<float> memory(18);
          FrameSlot slot;
          slot.normal_pa = std::span(memory).first(6);
          slot.shear_x_pa = std::span(memory).subspan(6, 6);
          slot.shear_y_pa = std::span(memory).last(6);
          while (!stop.stop_requested()) {
            std::fill(memory.begin(), memory.end(), offset.load());
            slot.time_ns += 10'000'000;
            worker.apply(slot);
            worker.after_publish();
          }
          worker.flush_to_store(true);
        }) {}

 private:
  std::jthread thread_;
};

class BiasWorkerTest : public ::testing::Test {
 protected:
  BiasWorkerTest() { setenv("STATE_DIRECTORY", folder_.path().c_str(), 1); }
  ~BiasWorkerTest() override {
    unsetenv("STATE_DIRECTORY");
    store_.request_stop();
  }

  void await_completed(std::uint32_t request) {
    while (status_.bias.completed() < request) {
      pollfd ready{wake_.fd(), POLLIN, 0};
      ASSERT_GT(poll(&ready, 1, testing::kPollPatience), 0);
      wake_.clear();
    }
  }

  const testing::TempFolder folder_;
  LogRing log_, store_log_;
  IoWakeup wake_;
  SensorStatus status_{"left", "trial"};
  BiasStore store_{store_log_, wake_};
};

TEST_F(BiasWorkerTest, AnswersARequestWhenItsBiasIsOnDisk) {
  const auto worker = store_.register_sensor(status_, kInfo, kSensor, log_);
  std::atomic<float> offset{1000};
  const Acquiring acquiring(*worker, offset);
  for (std::uint32_t i = 1; i <= 20; ++i) {
    offset = 1000.0F * static_cast<float>(i);
    await_completed(status_.bias.request(true));
    EXPECT_EQ(status_.bias.report.load().answer, BiasResult::taken);
    const auto kept = load_bias(bias_file_path(kSensor), kSensor);
    ASSERT_TRUE(kept);
    EXPECT_THAT(kept->bias_pa, ::testing::Each(1000.0F * static_cast<float>(i)));
  }
}

TEST_F(BiasWorkerTest, AnswersARequestAfterTheDeviceWasExchanged) {
  const auto first = store_.register_sensor(status_, kInfo, kSensor, log_);
  const std::uint32_t request = status_.bias.request(false);
  store_.unregister_sensor(first);
  BiasIdentity other = kSensor;
  other.device = "serial 8";
  const auto second = store_.register_sensor(status_, kInfo, other, log_);
  await_completed(request);
  EXPECT_EQ(status_.bias.report.load().answer, BiasResult::gone);
  EXPECT_EQ(status_.bias.report.load().origin, BiasOrigin::none);
}

TEST_F(BiasWorkerTest, RestoresTheBiasInTheNextRun) {
  std::atomic<float> offset{500};
  {
    const auto worker = store_.register_sensor(status_, kInfo, kSensor, log_);
    const Acquiring acquiring(*worker, offset);
    await_completed(status_.bias.request(true));
  }
  LogRing log;
  SensorStatus status("renamed", "trial");
  BiasStore store(log, wake_);
  const auto worker = store.register_sensor(status, kInfo, kSensor, log);
  const BiasReport report = status.bias.report.load();
  EXPECT_EQ(report.origin, BiasOrigin::command);
  EXPECT_TRUE(report.restored);
  EXPECT_EQ(status.facts().zero_trouble, "");
}

}  // namespace
}  // namespace slipd
