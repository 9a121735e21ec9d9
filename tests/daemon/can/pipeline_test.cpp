// A device that fails, from the driver to the bus: the trial driver, the pipeline and the CAN scheduler as
// in the daemon, on a fake port.
#include "daemon/pipeline/pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/can/scheduler.hpp"
#include "daemon/pipeline/modules.hpp"
#include "tests/daemon/can/fake_port.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::can {
namespace {

using namespace std::chrono_literals;
constexpr std::uint32_t kEstimateId = 0x5A0, kAlertId = 0x5C0;
constexpr std::uint64_t kNoMargin = 0xFFFF, kOutOfModel = 3, kStale = 6, kFault = 7, kSlip = 2;

class ServiceContext {
 public:
  explicit ServiceContext(const std::string& options)
      : modules_(std::filesystem::path(SLIPD_BINARY_DIR) / "test-drivers"),
        settings_(parse_settings(R"({"sensors": [{"name": "left", "driver": "trial", "stale_after_ms": 200,
                    "layout": {"grid": [16, 16], "pitch_mm": 0.9}, "options": )" +
                                     options + R"(}], "estimator": {"method": "moments"},
                    "can": {"interface": "can7", "allow_simulated": true}})",
                                 "test", modules_)),
        pipeline_(
            settings_, modules_, board_,
            [](const std::string&, const ChainSetup&) -> std::shared_ptr<const TrainedModel> {
              throw std::runtime_error("moments need no model");
            },
            &bell_),
        scheduler_(settings_, board_, port_, log_, Doorbell::Clock::now()) {
    pipeline_.start({});
  }
  ~ServiceContext() { EXPECT_TRUE(pipeline_.stop(std::chrono::steady_clock::now() + testing::kPatience)); }

  // Runs the scheduler, as the CAN thread does, until `enough`; false if that does not happen.
  bool talk_until(const std::function<bool()>& enough) {
    const auto patience = Doorbell::Clock::now() + testing::kPatience;
    while (!enough()) {
      const auto now = Doorbell::Clock::now();
      if (now > patience) return false;
      const std::uint32_t rung = bell_.ring_count();
      bell_.wait(rung, scheduler_.step(now));
    }
    return true;
  }

  bool said(std::uint32_t id, const char* signal, std::uint64_t value) const {
    return std::any_of(port_.sent.begin(), port_.sent.end(),
                       [&](const Message& each) { return each.id == id && raw(each, signal) == value; });
  }
  FakePort& port() { return port_; }

 private:
  DriverModules modules_;
  Settings settings_;
  Board board_;
  Doorbell bell_;
  Pipeline pipeline_;
  FakePort port_;
  LogRing log_;
  CanScheduler scheduler_;
};

void expect_no_margin_without_ok(const std::vector<Message>& sent) {
  for (const Message& each : sent) {
    if (raw(each, "State") == 0) continue;
    EXPECT_EQ(raw(each, "Gamma"), kNoMargin);
  }
}

TEST(CanPipeline, TheMarginOfADeviceIsSentAndItsSlipAtOnce) {
  ServiceContext context(R"({"gamma": 0.05})");
  ASSERT_TRUE(context.talk_until(
      [&] { return context.said(kAlertId, "Alert", kSlip) && context.said(kEstimateId, "State", 0); }));
  const auto sent = context.port().take(kEstimateId);
  const auto& last =
      *std::find_if(sent.begin(), sent.end(), [](const Message& m) { return raw(m, "State") == 0; });
  EXPECT_LE(raw(last, "Gamma"), 10000U);
  EXPECT_EQ(raw(last, "Simulated"), 1U);
  expect_no_margin_without_ok(sent);
}

TEST(CanPipeline, ADeviceThatVanishesIsAFaultOnTheBus) {
  ServiceContext context(R"({"behaviour": "throw_in_open"})");
  ASSERT_TRUE(context.talk_until([&] { return context.said(kEstimateId, "State", kFault); }));
  expect_no_margin_without_ok(context.port().take(kEstimateId));
}

TEST(CanPipeline, FramesThatFitNoContactHaveStateOutOfModel) {
  const testing::TempFolder folder;
  ServiceContext context(R"({"behaviour": "nonsense", "well_until": ")" + folder.file("ill").string() +
                         R"("})");
  ASSERT_TRUE(context.talk_until([&] { return context.said(kEstimateId, "State", 0); }));
  expect_no_margin_without_ok(context.port().take(kEstimateId));
  folder.write("ill", "");
  ASSERT_TRUE(context.talk_until([&] { return context.said(kEstimateId, "State", kOutOfModel); }));
  expect_no_margin_without_ok(context.port().take(kEstimateId));
}

TEST(CanPipeline, ARecordingThatEndsIsStaleOnTheBusAndItsAlertStays) {
  const testing::TempFolder folder;
  ServiceContext context(R"({"gamma": 0.05, "behaviour": "end", "well_until": ")" +
                         folder.file("over").string() + R"("})");
  ASSERT_TRUE(context.talk_until([&] { return context.said(kAlertId, "Alert", kSlip); }));
  folder.write("over", "");
  context.port().take(kEstimateId);  // the first messages are stale, because no frame had come
  ASSERT_TRUE(context.talk_until([&] { return context.said(kEstimateId, "State", kStale); }));
  const auto sent = context.port().take(kEstimateId);
  expect_no_margin_without_ok(sent);
  EXPECT_EQ(raw(sent.back(), "State"), kStale);
  EXPECT_EQ(raw(sent.back(), "Alert"), kSlip) << "that nothing comes is no sign of a safer grip";
  EXPECT_EQ(raw(context.port().take(kAlertId).back(), "Alert"), kSlip);
}

}  // namespace
}  // namespace slipd::can
