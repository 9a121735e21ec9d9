// When each message is sent, and what happens when the bus fails, in simulated time.
#include "daemon/can/scheduler.hpp"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <algorithm>
#include <set>

#include "daemon/pipeline/grasp_evaluator.hpp"
#include "tests/daemon/can/fake_port.hpp"

namespace slipd::can {
namespace {

using namespace std::chrono_literals;
constexpr std::uint32_t kEstimate = 0x5A0, kAlert = 0x5C0, kHeartbeat = 0x5DF;
constexpr std::uint64_t kUnknownMargin = 0xFFFF;

Settings settings_for(std::vector<std::string> names) {
  Settings settings;
  for (const auto& name : names) {
    settings.sensors.push_back({.setup = {.name = name,
                                          .layout = TaxelLayout::grid(4, 4, 1e-3),
                                          .profile = {},
                                          .device = {},
                                          .options = {}},
                                .driver = "none",
                                .friction = {},
                                .gain = {}});
  }
  settings.can.emplace().interface = "can7";
  return settings;
}

class CanSchedulerTest : public ::testing::Test {
 protected:
  void begin(Settings settings) {
    settings_ = std::move(settings);
    for (const auto& sensor : settings_.sensors) {
      board_.sensors.push_back(std::make_unique<SensorStatus>(sensor.setup.name, sensor.driver));
      board_.sensors.back()->link = DeviceLink::open;
    }
    for (const auto& grasp : settings_.grasps)
      board_.grasps.push_back(std::make_unique<GraspStatus>(grasp.name, std::vector<std::size_t>{0, 1}));
    grasp_evaluator_.emplace(board_, std::vector<std::size_t>{0, 1}, settings_.alerts, shared_);
    scheduler_.emplace(settings_, board_, port_, log_, now_);
  }

  // Publishes an estimate, as the estimate thread does at this moment.
  void publish(std::size_t sensor, std::optional<double> gamma, Alert alert = Alert::none,
               State state = State::ok) {
    Published reading = board_.sensors[sensor]->latest.load();
    ++reading.estimate.sequence;
    reading.estimate.published_ns = std::chrono::nanoseconds(now_.time_since_epoch()).count();
    reading.estimate.gamma = gamma;
    reading.estimate.state = state;
    reading.estimate.alert = alert;
    reading.estimate.friction = 0.5;
    reading.estimate.normal_n = 2;
    reading.estimate.shear_n = gamma ? std::optional(2 * 0.5 * (1 - *gamma)) : std::nullopt;
    board_.sensors[sensor]->latest.store(reading);
    grasp_evaluator_->mark_updated(sensor);
  }

  // Advances by a millisecond at a time, each with a new estimate of every sensor, as at 1 kHz, and calls
  // the scheduler when it is due.
  void pass(std::chrono::milliseconds time, std::optional<double> gamma = 0.7, Alert alert = Alert::none) {
    for (const auto end = now_ + time; now_ < end; now_ += 1ms) {
      for (std::size_t i = 0; i < board_.sensors.size(); ++i) publish(i, gamma, alert);
      grasp_evaluator_->evaluate();
      if (now_ >= due_) due_ = scheduler_->step(now_);
    }
  }
  void step() { due_ = scheduler_->step(now_); }
  Report report() const { return scheduler_->report().load(); }

  Settings settings_;
  Board board_;
  SharedBoard::Writer shared_{board_.shared};
  FakePort port_;
  LogRing log_;
  CanScheduler::Time now_{1000s}, due_{};
  std::optional<GraspEvaluator> grasp_evaluator_;
  std::optional<CanScheduler> scheduler_;
};

TEST_F(CanSchedulerTest, SendsEachEstimateEachPeriodAndAHeartbeatASecond) {
  begin(settings_for({"left", "right"}));
  pass(1000ms);
  for (const std::uint32_t id : {kEstimate, kEstimate + 1}) {
    const auto sent = port_.take(id);
    ASSERT_EQ(sent.size(), 100U);
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_EQ(raw(sent[i], "Counter"), (i + 1) % 16);
      EXPECT_EQ(raw(sent[i], "Gamma"), 7000U);
      EXPECT_EQ(raw(sent[i], "Sequence"), 10 * i + 1) << "the newest at that moment";
    }
  }
  EXPECT_EQ(port_.take(kHeartbeat).size(), 1U);
  EXPECT_EQ(port_.take(kAlert).size(), 0U);
  EXPECT_EQ(report().bus, Bus::up);
}

TEST_F(CanSchedulerTest, SendsSlidingBesideEachEstimateWhereItIsConfigured) {
  constexpr std::uint32_t kSlidingMessage = 0x5E0;
  for (const bool wanted : {false, true}) {
    Settings settings = settings_for({"left", "right"});
    settings.can->sliding = wanted;
    board_.sensors.clear();
    port_.sent.clear();
    begin(std::move(settings));
    pass(100ms);
    for (std::uint32_t i = 0; i < 2; ++i) {
      const auto estimates = port_.take(kEstimate + i), sliding = port_.take(kSlidingMessage + i);
      ASSERT_EQ(sliding.size(), wanted ? estimates.size() : 0U);
      for (std::size_t k = 0; k < sliding.size(); ++k) {
        EXPECT_EQ(raw(sliding[k], "Counter"), raw(estimates[k], "Counter"));
        EXPECT_EQ(raw(sliding[k], "Sequence"), raw(estimates[k], "Sequence"));
        EXPECT_EQ(raw(sliding[k], "Sliding"), 7U) << "nothing was published about it";
      }
    }
  }
}

TEST_F(CanSchedulerTest, AFullQueueRepeatsNoEstimateForTheSakeOfSliding) {
  Settings settings = settings_for({"left"});
  settings.can->sliding = true;
  begin(std::move(settings));
  port_.room = 1;
  step();
  EXPECT_EQ(port_.take(kEstimate).size(), 1U);
  port_.room = 1000;
  now_ += 2ms;
  step();
  EXPECT_EQ(port_.take(kEstimate).size(), 0U);
  EXPECT_EQ(port_.take(0x5E0).size(), 1U);
}

TEST_F(CanSchedulerTest, KeepsItsPeriodAfterADelay) {
  begin(settings_for({"left"}));
  step();
  for (const auto late : {0ms, 3ms, 9ms}) {
    now_ = CanScheduler::Time(1000s) + 100ms + late;
    EXPECT_EQ(scheduler_->step(now_), CanScheduler::Time(1000s) + 110ms);
  }
}

TEST_F(CanSchedulerTest, SendsAnAlertAtOnceRepeatsItAndSendsItsEnd) {
  begin(settings_for({"left"}));
  pass(13ms);
  publish(0, 0.3, Alert::warn);
  step();
  auto alerts = port_.take(kAlert);
  ASSERT_EQ(alerts.size(), 1U) << "between two periods";
  EXPECT_EQ(raw(alerts[0], "Alert"), 1U);
  EXPECT_EQ(raw(alerts[0], "Gamma"), 3000U);
  now_ += 1ms;
  pass(200ms, 0.3, Alert::warn);
  EXPECT_EQ(port_.take(kAlert).size(), 4U);
  publish(0, 0.1, Alert::slip);
  step();
  publish(0, 0.7);
  step();
  step();
  alerts = port_.take(kAlert);
  ASSERT_EQ(alerts.size(), 2U);
  EXPECT_EQ(raw(alerts[0], "Alert"), 2U);
  EXPECT_EQ(raw(alerts[1], "Alert"), 0U);
  EXPECT_EQ(raw(alerts[1], "Counter"), 6U);
}

TEST_F(CanSchedulerTest, AnEstimateThatIsNotRenewedIsStaleInTheNextPeriodAndItsAlertStays) {
  begin(settings_for({"left"}));
  pass(50ms, 0.3, Alert::warn);
  port_.sent.clear();
  while (now_ < CanScheduler::Time(1000s) + 200ms) {  // the estimate thread stands still
    now_ = due_;
    step();
  }
  const auto sent = port_.take(kEstimate);
  const auto stale =
      std::find_if(sent.begin(), sent.end(), [](const Message& m) { return raw(m, "State") == 6; });
  EXPECT_LE(stale - sent.begin(), 2) << "stale after 20 ms, sent in the period after";
  for (auto each = stale; each != sent.end(); ++each) {
    EXPECT_EQ(raw(*each, "Gamma"), kUnknownMargin);
    EXPECT_EQ(raw(*each, "Alert"), 1U);
  }
  EXPECT_GT(sent.end() - stale, 10) << "and it goes on saying so";
  for (const Message& each : port_.take(kAlert)) EXPECT_EQ(raw(each, "Alert"), 1U);
}

TEST_F(CanSchedulerTest, ThatNoAlertIsKnownIsToldByTheEstimatesAndNotByAlerts) {
  begin(settings_for({"left"}));
  pass(20ms);
  pass(20ms, std::nullopt, Alert::unknown);
  pass(20ms);
  EXPECT_TRUE(port_.take(kAlert).empty());
  std::set<std::uint64_t> told;
  for (const Message& each : port_.take(kEstimate)) told.insert(raw(each, "Alert"));
  EXPECT_EQ(told, (std::set<std::uint64_t>{0, 3}));
}

TEST_F(CanSchedulerTest, NoAlertIsUnknownOnceTheEstimateThreadStandsStill) {
  begin(settings_for({"left"}));
  pass(50ms);
  port_.sent.clear();
  while (now_ < CanScheduler::Time(1000s) + 200ms) {
    now_ = due_;
    step();
  }
  EXPECT_EQ(raw(port_.take(kEstimate).back(), "Alert"), 3U);
  scheduler_->send_final(now_);
  EXPECT_EQ(raw(port_.take(kEstimate).back(), "Alert"), 3U);
}

TEST_F(CanSchedulerTest, NoStateButOkHasAMargin) {
  begin(settings_for({"left"}));
  for (int state = 1; state <= static_cast<int>(State::fault); ++state) {
    publish(0, 0.9, Alert::none, static_cast<State>(state));
    now_ += 10ms;
    step();
    const auto sent = port_.take(kEstimate);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(raw(sent[0], "State"), static_cast<std::uint64_t>(state));
    EXPECT_EQ(raw(sent[0], "Gamma"), kUnknownMargin);
  }
}

TEST_F(CanSchedulerTest, ASimulatedSensorIsWithheldUnlessAllowed) {
  begin(settings_for({"left"}));
  board_.sensors[0]->simulated = true;
  pass(100ms, 0.1, Alert::slip);
  EXPECT_TRUE(port_.take(kEstimate).empty());
  EXPECT_TRUE(port_.take(kAlert).empty());
  EXPECT_EQ(report().withheld, 1U);
  settings_.can->allow_simulated = true;
  pass(100ms, 0.1, Alert::slip);
  const auto sent = port_.take(kEstimate);
  ASSERT_EQ(sent.size(), 10U);
  EXPECT_EQ(raw(sent[0], "Simulated"), 1U);
  EXPECT_EQ(raw(port_.take(kAlert).front(), "Simulated"), 1U);
}

TEST_F(CanSchedulerTest, AFullQueueLosesTheOldValueAndServesEverySensor) {
  begin(settings_for({"a", "b", "c", "d"}));
  std::array<std::size_t, 4> sent{};
  for (int period = 0; period < 40; ++period) {
    for (int ms = 0; ms < 10; ++ms) {
      port_.room = ms == 5 ? 2 : 0;  // room for half of the messages that are due
      pass(1ms, 0.001 * period);
    }
    for (std::uint32_t i = 0; i < 4; ++i) {
      for (const Message& each : port_.take(kEstimate + i)) {
        ++sent[i];
        EXPECT_EQ(raw(each, "Gamma"), 10U * static_cast<unsigned>(period))
            << "never what was true in an earlier period";
      }
    }
  }
  EXPECT_GE(*std::min_element(sent.begin(), sent.end()), 15U);
  EXPECT_GT(report().full, 100U);
  EXPECT_LT(port_.attempts, 600) << "it does not spin";
  EXPECT_EQ(report().bus, Bus::up);
}

TEST_F(CanSchedulerTest, AnAlertThatFoundNoRoomIsSentAsSoonAsThereIsSome) {
  begin(settings_for({"left"}));
  port_.room = 0;
  pass(5ms, 0.1, Alert::slip);
  EXPECT_TRUE(port_.sent.empty());
  port_.room = 1;
  pass(2ms, 0.1, Alert::slip);
  ASSERT_EQ(port_.sent.size(), 1U);
  EXPECT_EQ(port_.sent[0].id, kAlert) << "before all else";
}

TEST_F(CanSchedulerTest, AnInterfaceThatIsDownIsReportedAndUsedAgainLater) {
  begin(settings_for({"left"}));
  pass(20ms);
  port_.send_error = ENETDOWN;
  pass(500ms);
  EXPECT_EQ(report().bus, Bus::down);
  EXPECT_LT(port_.attempts, 60) << "it does not spin";
  port_.send_error = 0;
  port_.sent.clear();
  pass(50ms);
  EXPECT_EQ(report().bus, Bus::up);
  EXPECT_GE(port_.take(kEstimate).size(), 4U);
  EXPECT_EQ(port_.opened, 1);
}

TEST_F(CanSchedulerTest, AnInterfaceThatIsGoneIsLookedForAndUsedAgain) {
  begin(settings_for({"left"}));
  pass(20ms);
  port_.send_error = ENXIO;
  port_.open_error = ENODEV;
  pass(1000ms);
  EXPECT_EQ(report().bus, Bus::absent);
  EXPECT_EQ(report().error, ENODEV);
  EXPECT_LE(port_.opened, 8);
  port_.send_error = port_.open_error = 0;
  pass(300ms);
  EXPECT_EQ(report().bus, Bus::up);
  EXPECT_EQ(report().reopened, 1U);
}

TEST_F(CanSchedulerTest, TheControllersStateIsReported) {
  begin(settings_for({"left"}));
  const auto after = [&](std::uint32_t kind, std::uint8_t controller) {
    port_.errors.push_back({kind, {0, controller}});
    pass(10ms);
    return report().bus;
  };
  EXPECT_EQ(after(0, 0), Bus::up);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING), Bus::warning);
  EXPECT_EQ(after(CAN_ERR_CRTL | CAN_ERR_ACK, CAN_ERR_CRTL_TX_PASSIVE), Bus::passive);
  EXPECT_EQ(after(CAN_ERR_BUSOFF, 0), Bus::bus_off);
  EXPECT_EQ(after(CAN_ERR_RESTARTED, 0), Bus::up);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE), Bus::passive);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), Bus::up);
  EXPECT_EQ(report().bus_offs, 1U);
}

TEST_F(CanSchedulerTest, ItsLastMessagesAreStaleAndKeepTheAlert) {
  begin(settings_for({"left", "right"}));
  pass(25ms, 0.1, Alert::slip);
  port_.sent.clear();
  scheduler_->send_final(now_);
  for (std::uint32_t i = 0; i < 2; ++i) {
    const auto sent = port_.take(kEstimate + i);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(raw(sent[0], "State"), 6U);
    EXPECT_EQ(raw(sent[0], "Gamma"), kUnknownMargin);
    EXPECT_EQ(raw(sent[0], "Counter"), 4U) << "one on from the third";
    EXPECT_EQ(raw(sent[0], "Alert"), 2U);
    EXPECT_EQ(raw(port_.take(kAlert + i).back(), "Alert"), 2U);
  }
  EXPECT_EQ(raw(port_.take(kHeartbeat).back(), "Stopping"), 1U);
}

TEST_F(CanSchedulerTest, AGraspHasMessagesOfItsOwn) {
  Settings settings = settings_for({"left", "right"});
  settings.grasps.push_back({"both", {"left", "right"}, {}});
  begin(std::move(settings));
  pass(10ms);
  auto sent = port_.take(kEstimate + 2);
  ASSERT_EQ(sent.size(), 1U);
  for (; now_ < CanScheduler::Time(1000s) + 20ms; now_ += 1ms) {  // the grasp's margin is low
    publish(0, 0.6);
    publish(1, 0.1);
    grasp_evaluator_->evaluate();
    step();
  }
  const auto alerts = port_.take(kAlert + 2);
  ASSERT_GE(alerts.size(), 1U);
  EXPECT_EQ(raw(alerts[0], "Alert"), 1U);
  EXPECT_EQ(raw(alerts[0], "Gamma"), 3500U);
  EXPECT_EQ(raw(alerts[0], "GripIncrease"), 120U) << "1.3 N of 0.5 * 4 N; 5.2 N give the margin of one half";
}

TEST_F(CanSchedulerTest, AGraspWithoutNewEstimatesIsStaleToo) {
  Settings settings = settings_for({"left", "right"});
  settings.grasps.push_back({"both", {"left", "right"}, {}});
  begin(std::move(settings));
  pass(50ms);
  port_.sent.clear();
  now_ += 21ms;
  step();
  EXPECT_EQ(raw(port_.take(kEstimate + 2).back(), "State"), 6U);
}

TEST_F(CanSchedulerTest, ASlowDeviceIsAsStaleAsThePipelineSays) {
  begin(settings_for({"left"}));
  board_.sensors[0]->stale_after_ns = 120'000'000;  // three frames of a device of 25 Hz
  pass(1ms);
  now_ += 100ms;
  step();
  EXPECT_EQ(raw(port_.take(kEstimate).back(), "State"), 0U);
  now_ += 30ms;
  step();
  EXPECT_EQ(raw(port_.take(kEstimate).back(), "State"), 6U);
}

}  // namespace
}  // namespace slipd::can
