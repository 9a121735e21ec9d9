// fastdds-writer DOMAIN TOPIC TYPE RELIABILITY: publishes what standard input says by Fast DDS, the library
// behind ROS 2's default middleware: each line is a message's bytes (CDR with its encapsulation header) as
// hexadecimal text. RELIABILITY: `reliable`, as rclcpp's default, or `best_effort`, as its sensor data. TOPIC
// without its prefix `rt`, TYPE as ROS 2 names it on DDS. Prints `matched N` when a subscription has come or
// gone, and ends with its input.
#include <cstdio>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <iostream>
#include <string>

#include "../support/fastdds_any_type.hpp"

using namespace eprosima::fastdds::dds;

namespace {

class Teller : public DataWriterListener {
  void on_publication_matched(DataWriter* /*writer*/, const PublicationMatchedStatus& status) override {
    std::printf("matched %d\n", status.current_count);
    std::fflush(stdout);
  }
};

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
