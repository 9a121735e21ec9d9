// What Cyclone DDS puts on the wire for each message is what the encoder makes, so that recordings and topics
// have the same bytes; and a reader with rclcpp's default QoS gets it, with the type hash in the user data.
#include <dds/ddsi/ddsi_serdata.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "bridges/ros2/dds/cyclone_log.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/ros2/messages/cdr.hpp"
#include "bridges/ros2/messages/sensor_messages.hpp"
#include "tests/support/awaiting.hpp"

namespace slipd::ros2 {
namespace {

using ::testing::HasSubstr;

// A domain of this process, so that tests that run at the same time do not meet.
unsigned own_domain() {
  return 1 + static_cast<unsigned>(getpid()) % 100;
}

// Waits until `condition` holds, which events of `entity` change.
template <class Condition>
void await(dds_entity_t participant, dds_entity_t entity, std::uint32_t events, const Condition& condition) {
  const dds_entity_t waiting = dds_create_waitset(participant);
  dds_set_status_mask(entity, events);
  dds_waitset_attach(waiting, entity, 0);
  while (!condition()) ASSERT_GT(dds_waitset_wait(waiting, nullptr, 0, DDS_SECS(60)), 0);
  dds_delete(waiting);
}

SlipEstimate sample_estimate() {
  SlipEstimate estimate;
  estimate.header = {.stamp = {.sec = 12, .nanosec = 34}, .frame_id = "left_fingertip"};
  estimate.name = "left";
  estimate.state = 0;
  estimate.alert = 1;
  estimate.seq = 0x0102030405060708;
  double value = 0.5;
  for (double* number :
       {&estimate.margin, &estimate.normal_force, &estimate.shear_force_x, &estimate.sliding_for})
    *number = value += 1.25;
  return estimate;
}

DiagnosticArray sample_diagnostics() {
  DiagnosticArray message;
  message.status.resize(2);
  message.status[1].level.value = 2;
  message.status[1].name = "slipd: left";
  message.status[1].values = {{.key = "state", .value = "ok"}, {.key = "age", .value = ""}};
  return message;
}

PointCloud2 sample_cloud() {
  const std::array<double, 3> x{0, 1, 2};
  const std::array<float, 3> pa{1, 2, 3};
  PointCloud2 cloud;
  fill_cloud({.stamp = {}, .frame_id = "f"}, {x, x, pa, pa, pa}, cloud);
  return cloud;
}

class OnTheWire : public ::testing::Test {
 protected:
  // The bytes that a reader with rclcpp's default QoS gets, and the user data of the writer.
  template <class T>
  void expect_equal_bytes(const T& message) {
    const Writer<T> writer(node_, "/a/topic", {});
    const dds_entity_t topic =
        dds_create_topic(participant_, &DdsType<T>::descriptor(), "rt/a/topic", nullptr, nullptr);
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    const dds_entity_t reader = dds_create_reader(participant_, topic, qos, nullptr);
    dds_delete_qos(qos);
    ASSERT_GT(reader, 0);
    const dds_entity_t waiting = dds_create_waitset(participant_);
    dds_set_status_mask(reader, DDS_SUBSCRIPTION_MATCHED_STATUS | DDS_DATA_AVAILABLE_STATUS);
    dds_waitset_attach(waiting, reader, 0);
    dds_subscription_matched_status_t matched{};
    while (dds_get_subscription_matched_status(reader, &matched) == DDS_RETCODE_OK &&
           matched.current_count == 0)
      ASSERT_GT(dds_waitset_wait(waiting, nullptr, 0, DDS_SECS(60)), 0);
    ASSERT_TRUE(writer.write(message));
    ddsi_serdata* taken = nullptr;
    dds_sample_info_t info{};
    while (dds_takecdr(reader, &taken, 1, &info, DDS_ANY_STATE) < 1)
      ASSERT_GT(dds_waitset_wait(waiting, nullptr, 0, DDS_SECS(60)), 0);
    const std::uint32_t bytes = ddsi_serdata_size(taken);
    std::vector<std::uint8_t> wire(bytes);
    ddsi_serdata_to_ser(taken, 0, bytes, wire.data());
    ddsi_serdata_unref(taken);
    std::vector<std::uint8_t> own;
    encode(message, own);
    // The wire's length is a multiple of four: the header's last byte counts the padding.
    const std::size_t padding = wire.at(3) & 3U;
    wire[3] = 0;
    wire.resize(std::max(wire.size() - padding, own.size()));
    EXPECT_EQ(wire, own) << T::kName;
    expect_hash<T>(reader);
    dds_delete(waiting);
    dds_delete(reader);
    dds_delete(topic);
  }

  template <class T>
  static void expect_hash(dds_entity_t reader) {
    dds_instance_handle_t writer = 0;
    ASSERT_EQ(dds_get_matched_publications(reader, &writer, 1), 1);
    dds_builtintopic_endpoint_t* const endpoint = dds_get_matched_publication_data(reader, writer);
    ASSERT_NE(endpoint, nullptr);
    void* data = nullptr;
    std::size_t bytes = 0;
    dds_qget_userdata(endpoint->qos, &data, &bytes);
    EXPECT_EQ(std::string(static_cast<const char*>(data), bytes),
              "typehash=RIHS01_" + std::string(T::kTypeHash) + ";");
    EXPECT_EQ(std::string(endpoint->type_name), dds_name(T::kName));
    dds_free(data);
    dds_builtintopic_free_endpoint(endpoint);
  }

  std::atomic<int> changes_{0};
  Node node_{{.domain = own_domain()}, [this] { ++changes_; }};
  dds_entity_t participant_ = dds_create_participant(own_domain(), nullptr, nullptr);
};

TEST_F(OnTheWire, MessagesHaveTheEncodersBytesAndTheTypesHash) {
  expect_equal_bytes(Float32{.data = 0.25F});
  expect_equal_bytes(wrench_of(sample_estimate()));
  expect_equal_bytes(sample_estimate());
  expect_equal_bytes(sample_cloud());
  expect_equal_bytes(sample_diagnostics());
}

TEST_F(OnTheWire, AWriterSeesItsReadersComeAndGo) {
  const Writer<Float32> writer(node_, "/a/topic", {});
  EXPECT_FALSE(writer.has_readers());
  const dds_entity_t topic =
      dds_create_topic(participant_, &DdsType<Float32>::descriptor(), "rt/a/topic", nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant_, topic, nullptr, nullptr);
  slipd::testing::await_true([&] { return writer.has_readers(); });
  EXPECT_GT(changes_.load(), 0);
  dds_delete(reader);
  slipd::testing::await_true([&] { return !writer.has_readers(); });
}

// What `ros2 node list` reads: the node's name, and which writers are its own.
template <std::size_t BYTES>
void expect_node_info(bool humble) {
  using Type = DdsType<ParticipantEntitiesInfo<BYTES>>;
  const unsigned domain = 1 + (own_domain() + 50) % 100;
  Node node({.domain = domain, .name = "finger", .humble = humble});
  const Writer<Float32> writer(node, "/a/topic", {});
  node.announce();
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  const std::string name = dds_name(ParticipantEntitiesInfo<BYTES>::kName);
  dds_topic_descriptor_t type = Type::descriptor();
  std::unique_ptr<dds_topic_descriptor_t> renamed(new dds_topic_descriptor_t{
      type.m_size, type.m_align, type.m_flagset, type.m_nkeys, name.c_str(), type.m_keys, type.m_nops,
      type.m_ops, type.m_meta, type.type_information, type.type_mapping, type.restrict_data_representation});
  const dds_entity_t topic =
      dds_create_topic(participant, renamed.get(), "ros_discovery_info", nullptr, nullptr);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, nullptr);
  dds_delete_qos(qos);
  void* taken = nullptr;
  dds_sample_info_t info{};
  await(participant, reader, DDS_DATA_AVAILABLE_STATUS,
        [&] { return dds_take(reader, &taken, &info, 1, 1) == 1; });
  const auto& sample = *static_cast<typename Type::Sample*>(taken);
  ASSERT_EQ(sample.node_entities_info_seq._length, 1U);
  EXPECT_STREQ(sample.node_entities_info_seq._buffer[0].node_name, "finger");
  EXPECT_STREQ(sample.node_entities_info_seq._buffer[0].node_namespace, "/");
  ASSERT_EQ(sample.node_entities_info_seq._buffer[0].writer_gid_seq._length, 1U);
  const auto& gid = sample.node_entities_info_seq._buffer[0].writer_gid_seq._buffer[0].data;
  EXPECT_EQ(sizeof gid, BYTES);
  dds_guid_t guid{};
  dds_get_guid(writer.entity(), &guid);
  EXPECT_EQ(std::memcmp(gid, guid.v, sizeof guid.v), 0);
  for (std::size_t i = sizeof guid.v; i < BYTES; ++i) EXPECT_EQ(gid[i], 0);
  dds_return_loan(reader, &taken, 1);
}

TEST(CyclonesLines, OfASampleThatItCannotReadNameTheTopic) {
  const std::string failed =
      "1.2 [7] recvUC: data(application, vendor 1.15): 1:2:0:103 #3: deserialization "
      "rt/left/taxels/std_msgs::msg::dds_::Float32MultiArray_ failed (for reasons unknown)";
  EXPECT_EQ(topic_of_refusal(failed), "/left/taxels");
  for (const std::string_view other : {"", "deserialization rt/", "deserialization rt/ failed", "failed",
                                       "deserialization ros_discovery_info/T failed", "1.2 [7] recv: failed"})
    EXPECT_EQ(topic_of_refusal(other), std::nullopt) << other;
}

TEST(Nodes, AreListedWithTheirWriters) {
  expect_node_info<kGidBytes>(false);
}

TEST(Nodes, AreListedForHumbleWithLongerIdentifiers) {
  expect_node_info<kHumbleGidBytes>(true);
}

TEST(Nodes, AreReadInADomainOfFiftyParticipants) {
  constexpr int kOthers = 50;
  const unsigned domain = 1 + (own_domain() + 25) % 100;
  Node node({.domain = domain});
  const Writer<Float32> writer(node, "/a/topic", {});
  std::vector<dds_entity_t> readers;
  for (int i = 0; i < kOthers; ++i) {
    const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
    ASSERT_GT(participant, 0);
    const dds_entity_t topic =
        dds_create_topic(participant, &DdsType<Float32>::descriptor(), "rt/a/topic", nullptr, nullptr);
    readers.push_back(dds_create_reader(participant, topic, nullptr, nullptr));
    ASSERT_GT(readers.back(), 0);
  }
  slipd::testing::await_true([&] {
    return std::all_of(readers.begin(), readers.end(), [](dds_entity_t reader) {
      dds_subscription_matched_status_t matched{};
      return dds_get_subscription_matched_status(reader, &matched) == DDS_RETCODE_OK &&
             matched.current_count == 1;
    });
  });
  ASSERT_TRUE(writer.write(Float32{.data = 0.5F}));
  for (const dds_entity_t reader : readers) {
    void* taken = nullptr;
    dds_sample_info_t info{};
    slipd::testing::await_true([&] { return dds_take(reader, &taken, &info, 1, 1) == 1; });
    dds_return_loan(reader, &taken, 1);
  }
}

TEST(Nodes, WithoutTheirInterfaceSayWhatToChange) {
  try {
    const Node node({.domain = own_domain(), .interfaces = {"no-such-interface"}});
    FAIL() << "made";
  } catch (const DdsError& error) {
    EXPECT_THAT(error.what(), HasSubstr("`network` in the settings"));
  }
}

}  // namespace
}  // namespace slipd::ros2
