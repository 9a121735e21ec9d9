// The topics of a sensor while estimates come and fail to come, as a reader sees them: nothing runs but
// Subjects.
#include "bridges/ros2/subjects.hpp"

#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bridges/support/clock.hpp"
#include "tests/support/awaiting.hpp"

namespace slipd::ros2 {
namespace {

using slipd::testing::await_true;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::SizeIs;

constexpr std::chrono::milliseconds kDeadline{200}, kLease{400};

// A domain of this process, apart from those of dds_test.cpp.
unsigned subjects_domain() {
  return 1 + (static_cast<unsigned>(getpid()) + 75) % 100;
}

struct ReaderAsks {
  std::chrono::nanoseconds deadline{0}, lease{0};
};

template <class T>
class TopicReader {
 public:
  using Sample = typename DdsType<T>::Sample;

  TopicReader(dds_entity_t participant, const std::string& topic, ReaderAsks asks = {}) {
    const dds_entity_t entity =
        dds_create_topic(participant, &DdsType<T>::descriptor(), ("rt" + topic).c_str(), nullptr, nullptr);
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    if (asks.deadline.count() > 0) dds_qset_deadline(qos, asks.deadline.count());
    if (asks.lease.count() > 0) dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, asks.lease.count());
    reader_ = dds_create_reader(participant, entity, qos, nullptr);
    dds_delete_qos(qos);
  }
  ~TopicReader() { dds_delete(reader_); }
  TopicReader(const TopicReader&) = delete;
  TopicReader& operator=(const TopicReader&) = delete;

  bool matched() const {
    dds_subscription_matched_status_t status{};
    return dds_get_subscription_matched_status(reader_, &status) == DDS_RETCODE_OK &&
           status.current_count == 1;
  }
  // The policy that keeps a writer from matching; 0: none does.
  std::uint32_t incompatible() const {
    dds_requested_incompatible_qos_status_t status{};
    dds_get_requested_incompatible_qos_status(reader_, &status);
    return status.total_count == 0 ? 0 : status.last_policy_id;
  }
  // Whether the topic's data was disposed of, with the last message that came.
  bool disposed() const {
    void* data = nullptr;
    dds_sample_info_t info{};
    if (dds_read_mask(reader_, &data, &info, 1, 1,
                      DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE | DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE) != 1)
      return false;
    dds_return_loan(reader_, &data, 1);
    return true;
  }
  // All messages so far, as `keep` makes them of samples.
  template <class Keep>
  auto told(const Keep& keep) {
    using Kept = decltype(keep(std::declval<const Sample&>()));
    std::vector<Kept> all;
    constexpr int kMost = 1000;
    std::vector<void*> data(kMost);
    std::vector<dds_sample_info_t> info(kMost);
    const int count = dds_read(reader_, data.data(), info.data(), kMost, kMost);
    for (int i = 0; i < count; ++i) {
      if (info[static_cast<std::size_t>(i)].valid_data)
        all.push_back(keep(*static_cast<const Sample*>(data[static_cast<std::size_t>(i)])));
    }
    if (count > 0) dds_return_loan(reader_, data.data(), count);
    return all;
  }

 private:
  dds_entity_t reader_ = 0;
};

using StateAndAlert = std::pair<int, int>;

class Told : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto topic = [](const char* leaf) {
      TopicOptions options;
      options.writer.lease = kLease;
      if (std::string(leaf) != "alert") options.writer.deadline = kDeadline;
      return options;
    };
    std::string other;
    ASSERT_TRUE(subjects_->add({"left", "left", "sim", "/t", topic}, other));
    await_true(
        [&] { return estimate_.matched() && margin_.matched() && wrench_.matched() && alert_.matched(); });
    subjects_->set_connected(true);
  }

  // A sample of now that is good for so long.
  static slipd_estimate sample(int alert, std::chrono::nanoseconds good, std::uint64_t seq = 7) {
    slipd_estimate one{};
    std::snprintf(one.name, sizeof one.name, "left");
    one.state = SLIPD_STATE_OK;
    one.alert = alert;
    one.event = SLIPD_EVENT_ESTIMATE;
    one.sequence = seq;
    one.time_ns = bridges::monotonic_ns();
    one.realtime_ns = bridges::realtime_ns();
    one.gamma = one.gamma_low = 0.5;
    one.valid_until_ns = one.time_ns + good.count();
    return one;
  }
  // Since the first sample. Before it there is no estimate: each beat says so.
  std::vector<StateAndAlert> estimates() {
    std::vector<StateAndAlert> all =
        estimate_.told([](const auto& m) { return StateAndAlert(m.state, m.alert); });
    const auto sampled = [](const StateAndAlert& one) { return one.first != SlipEstimate::kStale; };
    all.erase(all.begin(), std::find_if(all.begin(), all.end(), sampled));
    return all;
  }
  std::vector<StateAndAlert> alerts() {
    return alert_.told([](const auto& m) { return StateAndAlert(m.state, m.alert); });
  }
  static bool has(const std::vector<StateAndAlert>& all, int state, int alert, int times = 1) {
    return std::count(all.begin(), all.end(), StateAndAlert(state, alert)) >= times;
  }

  static constexpr std::chrono::hours kLong{1};
  Node node_{{.domain = subjects_domain()}};
  dds_entity_t participant_ = dds_create_participant(subjects_domain(), nullptr, nullptr);
  Recorder recorder_{""};
  TopicReader<SlipEstimate> estimate_{participant_, "/t/left/estimate", {kDeadline, kLease}};
  TopicReader<SlipEstimate> alert_{participant_, "/t/left/alert", {{}, kLease}};
  TopicReader<Float32> margin_{participant_, "/t/left/margin", {2 * kDeadline, 2 * kLease}};
  TopicReader<WrenchStamped> wrench_{participant_, "/t/left/wrench"};
  std::unique_ptr<Subjects> subjects_ = std::make_unique<Subjects>(node_, recorder_, Subjects::beat(0.02));
};

TEST_F(Told, AReaderThatAsksForMoreThanIsPromisedDoesNotMatch) {
  const TopicReader<Float32> sooner(participant_, "/t/left/margin", {kDeadline / 2, {}});
  const TopicReader<Float32> shorter(participant_, "/t/left/margin", {{}, kLease / 2});
  await_true([&] { return sooner.incompatible() != 0 && shorter.incompatible() != 0; });
  EXPECT_EQ(sooner.incompatible(), std::uint32_t{DDS_DEADLINE_QOS_POLICY_ID});
  EXPECT_EQ(shorter.incompatible(), std::uint32_t{DDS_LIVELINESS_QOS_POLICY_ID});
}

TEST_F(Told, AnEstimateThatNoneFollowsIsStaleAndItsRaisedAlertStands) {
  subjects_->take(sample(SLIPD_ALERT_SLIP, std::chrono::milliseconds(20)));
  await_true([&] { return has(estimates(), SlipEstimate::kStale, SLIPD_ALERT_SLIP, 5); });
  EXPECT_FALSE(has(estimates(), SlipEstimate::kStale, SLIPD_ALERT_UNKNOWN));
  EXPECT_TRUE(std::isnan(margin_.told([](const auto& m) { return m.data; }).back()));
  EXPECT_THAT(alerts(), SizeIs(1)) << "a raised alert that stands is no news";
}

TEST_F(Told, WithoutEstimatesTheAlertIsUnknownAndThatIsNews) {
  subjects_->take(sample(SLIPD_ALERT_NONE, std::chrono::milliseconds(20)));
  await_true([&] { return has(estimates(), SlipEstimate::kStale, SLIPD_ALERT_UNKNOWN, 5); });
  await_true([&] { return alerts().size() >= 2; });
  EXPECT_THAT(alerts(), ElementsAre(StateAndAlert(SlipEstimate::kOk, SLIPD_ALERT_NONE),
                                    StateAndAlert(SlipEstimate::kStale, SLIPD_ALERT_UNKNOWN)));
  EXPECT_THAT(subjects_->diagnostics(1).at(0).values.at(1).value, "unknown");
}

TEST_F(Told, ASlipdThatGoesIsDisconnectedAtOnceAndAgainAndAgain) {
  subjects_->take(sample(SLIPD_ALERT_NONE, kLong));
  subjects_->set_connected(false);
  await_true([&] { return has(estimates(), SlipEstimate::kDisconnected, SLIPD_ALERT_UNKNOWN, 5); });
  EXPECT_FALSE(has(estimates(), SlipEstimate::kDisconnected, SLIPD_ALERT_NONE));
  EXPECT_TRUE(std::isnan(margin_.told([](const auto& m) { return m.data; }).back()));
}

TEST_F(Told, AnAlertThatOnlyItsEventHasBroughtStands) {
  subjects_->take(sample(SLIPD_ALERT_NONE, kLong));
  slipd_estimate raised = sample(SLIPD_ALERT_WARN, kLong, 8);
  raised.event = SLIPD_EVENT_ALERT;
  subjects_->take(raised);
  subjects_->set_connected(false);
  await_true([&] { return has(estimates(), SlipEstimate::kDisconnected, SLIPD_ALERT_WARN); });
}

TEST_F(Told, AFaultStandsWhileSlipdAnswers) {
  slipd_estimate fault = sample(SLIPD_ALERT_UNKNOWN, kLong);
  fault.state = SLIPD_STATE_FAULT;
  fault.valid_until_ns = 0;
  subjects_->take(fault);
  await_true([&] { return has(estimates(), SlipEstimate::kFault, SLIPD_ALERT_UNKNOWN, 5); });
  subjects_->set_connected(false);
  await_true([&] { return has(estimates(), SlipEstimate::kDisconnected, SLIPD_ALERT_UNKNOWN); });
}

TEST_F(Told, TheEndIsSaidBeforeTheTopicsGo) {
  subjects_->take(sample(SLIPD_ALERT_SLIP, kLong));
  subjects_.reset();
  await_true([&] { return !estimate_.matched() && !margin_.matched(); });
  await_true([&] { return estimate_.disposed() && margin_.disposed(); });
  EXPECT_EQ(estimates().back(), StateAndAlert(SlipEstimate::kDisconnected, SLIPD_ALERT_SLIP));
  EXPECT_TRUE(std::isnan(margin_.told([](const auto& m) { return m.data; }).back()));
}

// slipd converts the sample's time anew for each message, by clocks that it reads one after the other.
TEST_F(Told, AllMessagesOfASampleHaveOneStamp) {
  slipd_estimate one = sample(SLIPD_ALERT_NONE, kLong);
  const std::int64_t first_ns = subjects_->stamp_of("left", one.sequence, one.realtime_ns);
  EXPECT_EQ(first_ns, one.realtime_ns);
  one.realtime_ns += 3000;
  subjects_->take(one);
  one.event = SLIPD_EVENT_ALERT;
  one.alert = SLIPD_ALERT_WARN;
  one.realtime_ns += 150'000;
  subjects_->take(one);
  EXPECT_EQ(subjects_->stamp_of("left", one.sequence, one.realtime_ns), first_ns);
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  const auto stamp = [](const auto& m) { return kSecondNs * m.header.stamp.sec + m.header.stamp.nanosec; };
  await_true([&] { return alerts().size() >= 2; });
  EXPECT_THAT(alert_.told(stamp), Each(first_ns));
  // Before, messages without a sample had stamps of their own.
  EXPECT_EQ(estimate_.told(stamp).back(), first_ns);
  EXPECT_EQ(wrench_.told(stamp).back(), first_ns);
}

// A slipd that began anew counts from 0.
TEST(Stamps, OfAnotherSampleOfTheSameNumberAreItsOwn) {
  Stamps stamps;
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  EXPECT_EQ(stamps.of(3, kSecondNs), kSecondNs);
  EXPECT_EQ(stamps.of(3, kSecondNs + 100), kSecondNs);
  EXPECT_EQ(stamps.of(3, 2 * kSecondNs), 2 * kSecondNs);
}

TEST(Beats, AreAsLongAsEstimatesMayBeOldAndTenASecondAtMost) {
  EXPECT_EQ(Subjects::beat(0.001), std::chrono::milliseconds(100));
  EXPECT_EQ(Subjects::beat(2), std::chrono::seconds(2));
}

}  // namespace
}  // namespace slipd::ros2
