// fastdds-reader NETWORK DOMAIN MESSAGES TOPIC TYPE [TOPIC TYPE …]: reads topics with rclcpp's default QoS by
// Fast DDS, the library behind ROS 2's default middleware, and prints a line for each message: TOPIC, the
// writer's user data, and the bytes as hexadecimal text. Ends when each topic has brought MESSAGES of them.
// Topics without their prefix `rt`, types as ROS 2 names them on DDS.
//
// With DEADLINE_MS and LEASE_MS in the environment it asks each topic for a message at least every
// DEADLINE_MS (not `alert`, which is rare), and for a writer that shows within LEASE_MS that it lives. Lines
// then also say `TOPIC missed N`, the deadlines so far, and `TOPIC alive N`, the writers that live.
//
// NETWORK: `default`, Fast DDS's transports as they are, which a ROS 2 node has by default; `loopback`, the
// loopback interface only, as with ROS_LOCALHOST_ONLY=1; `localhost`, all interfaces, but other nodes are
// found on 127.0.0.1 only, as with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "../../support/fastdds_any_type.hpp"

using namespace eprosima::fastdds::dds;

namespace {

std::mutex mutex;
std::condition_variable changed;
std::map<std::string, int> counts;
std::map<std::string, std::string> user_data;  // by topic

class Discovery : public DomainParticipantListener {
  void on_publisher_discovery(DomainParticipant*,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& info) override {
    const auto& bytes = info.info.m_qos.m_userData.getValue();
    const std::lock_guard<std::mutex> lock(mutex);
    user_data[info.info.topicName().to_string()] = std::string(bytes.begin(), bytes.end());
  }
};

class Printer : public DataReaderListener {
 public:
  explicit Printer(std::string topic) : topic_(std::move(topic)) {}
  void on_requested_deadline_missed(DataReader* /*reader*/,
                                    const RequestedDeadlineMissedStatus& status) override {
    tell("missed", static_cast<int>(status.total_count));
  }
  void on_liveliness_changed(DataReader* /*reader*/, const LivelinessChangedStatus& status) override {
    tell("alive", status.alive_count);
  }
  void on_data_available(DataReader* reader) override {
    std::vector<unsigned char> sample;
    SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      const std::lock_guard<std::mutex> lock(mutex);
      const std::string& data = user_data[topic_[0] == '/' ? "rt" + topic_ : topic_];
      std::printf("%s %s ", topic_.c_str(), data.empty() ? "-" : data.c_str());
      const auto& writer = info.sample_identity.writer_guid();
      for (const unsigned char byte : writer.guidPrefix.value) std::printf("%02x", byte);
      for (const unsigned char byte : writer.entityId.value) std::printf("%02x", byte);
      std::printf(" ");
      for (const unsigned char byte : sample) std::printf("%02x", byte);
      std::printf("\n");
      std::fflush(stdout);
      ++counts[topic_];
      changed.notify_all();
    }
  }

 private:
  void tell(const char* what, int number) {
    const std::lock_guard<std::mutex> lock(mutex);
    std::printf("%s %s %d\n", topic_.c_str(), what, number);
    std::fflush(stdout);
  }

  std::string topic_;
};

eprosima::fastrtps::Duration_t milliseconds(const char* text) {
  return eprosima::fastrtps::Duration_t(1e-3 * std::atof(text));
}

// Whether DEADLINE_MS and LEASE_MS are there, which `qos` then asks for.
bool ask_for_promises(const std::string& topic, DataReaderQos& qos) {
  const char* const deadline = std::getenv("DEADLINE_MS");
  const char* const lease = std::getenv("LEASE_MS");
  if (deadline == nullptr || lease == nullptr) return false;
  const bool rare = topic.find("/alert") != std::string::npos;
  qos.deadline().period = rare ? eprosima::fastrtps::c_TimeInfinite : milliseconds(deadline);
  qos.liveliness().kind = MANUAL_BY_TOPIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = milliseconds(lease);
  return true;
}

}  // namespace

// Fast DDS asks as many participants of a peer as ROS 2 has it ask.
constexpr std::uint32_t kPeers = 32;

DomainParticipantQos qos_of(const std::string& network) {
  DomainParticipantQos own = PARTICIPANT_QOS_DEFAULT;
  if (network == "default") return own;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  own.transport().use_builtin_transports = false;
  own.transport().user_transports.push_back(udp);
  if (network == "loopback") {
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    return own;
  }
  udp->maxInitialPeersRange = kPeers;
  auto& discovery = own.wire_protocol().builtin;
  discovery.metatrafficUnicastLocatorList.push_back(eprosima::fastrtps::rtps::Locator_t());
  eprosima::fastrtps::rtps::Locator_t peer;
  eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, "127.0.0.1");
  discovery.initialPeersList.push_back(peer);
  return own;
}

int main(int argc, char** argv) {
  if (argc < 6) return 2;
  Discovery discovery;
  DomainParticipant* const participant = DomainParticipantFactory::get_instance()->create_participant(
      static_cast<unsigned>(std::atoi(argv[2])), qos_of(argv[1]), &discovery, StatusMask::none());
  if (participant == nullptr) return 1;
  Subscriber* const subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  DataReaderQos qos = DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.history().kind = KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 10;
  const int wanted = std::atoi(argv[3]);
  std::size_t topics = 0;
  for (int i = 4; i + 1 < argc; i += 2, ++topics) {
    const bool ros = argv[i][0] == '/';
    TypeSupport type(new AnyType(argv[i + 1]));
    type.register_type(participant);
    Topic* const topic =
        participant->create_topic(std::string(ros ? "rt" : "") + argv[i], argv[i + 1], TOPIC_QOS_DEFAULT);
    qos.durability().kind = ros ? VOLATILE_DURABILITY_QOS : TRANSIENT_LOCAL_DURABILITY_QOS;
    StatusMask events = StatusMask::data_available();
    if (ask_for_promises(argv[i], qos))
      events << StatusMask::requested_deadline_missed() << StatusMask::liveliness_changed();
    if (subscriber->create_datareader(topic, qos, new Printer(argv[i]), events) == nullptr) return 1;
  }
  std::unique_lock<std::mutex> lock(mutex);
  changed.wait(lock, [&] {
    if (wanted == 0 || counts.size() < topics) return false;
    for (const auto& [topic, count] : counts)
      if (count < wanted) return false;
    return true;
  });
  std::fflush(stdout);
  std::_Exit(0);  // Fast DDS would take seconds to end its threads
}
