// fastdds-writer DOMAIN TOPIC TYPE RELIABILITY: publishes what standard input says by Fast DDS, the library
// behind ROS 2's default middleware: each line is a message's bytes (CDR with its encapsulation header) as
// hexadecimal text. RELIABILITY: `reliable`, as rclcpp's default, or `best_effort`, as its sensor data. TOPIC
// without its prefix `rt`, TYPE as ROS 2 names it on DDS. Prints `matched N` when a subscription has come or
// gone, and ends with its input.
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <iostream>
#include <string>
#include <vector>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::SerializedPayload_t;

namespace {

using Bytes = std::vector<unsigned char>;
constexpr std::uint32_t kMostBytes = 1 << 20;

// A type of which nothing is known but its name: samples are their bytes.
class AnyType : public TopicDataType {
 public:
  explicit AnyType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kMostBytes;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = bytes.size() > 1 && bytes[1] == 0 ? CDR_BE : CDR_LE;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    return true;
  }
  bool deserialize(SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    const auto size = static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size());
    return [size] { return size; };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

class Teller : public DataWriterListener {
  void on_publication_matched(DataWriter* /*writer*/, const PublicationMatchedStatus& status) override {
    std::printf("matched %d\n", status.current_count);
    std::fflush(stdout);
  }
};

Bytes bytes_of(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<unsigned char>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  DomainParticipant* const participant = DomainParticipantFactory::get_instance()->create_participant(
      static_cast<unsigned>(std::stoi(argv[1])), PARTICIPANT_QOS_DEFAULT);
  if (participant == nullptr) return 1;
  TypeSupport type(new AnyType(argv[3]));
  type.register_type(participant);
  Topic* const topic = participant->create_topic(std::string("rt") + argv[2], argv[3], TOPIC_QOS_DEFAULT);
  DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
  qos.reliability().kind =
      std::string(argv[4]) == "reliable" ? RELIABLE_RELIABILITY_QOS : BEST_EFFORT_RELIABILITY_QOS;
  qos.history().kind = KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 10;
  // As ROS 2 has it, so that messages are not kept at their largest size.
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  Teller teller;
  Publisher* const publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
  DataWriter* const writer = publisher->create_datawriter(topic, qos, &teller);
  if (writer == nullptr) return 1;
  for (std::string line; std::getline(std::cin, line);) {
    Bytes bytes = bytes_of(line);
    if (!writer->write(&bytes)) return 1;
  }
  publisher->delete_datawriter(writer);
  participant->delete_contained_entities();
  DomainParticipantFactory::get_instance()->delete_participant(participant);
  return 0;
}
