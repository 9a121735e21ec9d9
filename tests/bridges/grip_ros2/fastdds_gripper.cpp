// fastdds-gripper DOMAIN ACTION TYPE: the topics of an action's server, with ROS 2's names and QoS, by Fast
// DDS. Prints `goal HEX` for each request, as its bytes (CDR with its encapsulation header). Publishes what
// standard input says, `status HEX` the list of goals, `feedback HEX` feedback, and ends with its input. What
// the bytes mean is for the caller. ACTION: "/gripper/cmd"; TYPE: GripperCommand or ParallelGripperCommand.
#include <cstdio>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <iostream>
#include <string>

#include "../support/fastdds_any_type.hpp"

using namespace eprosima::fastdds::dds;

namespace {

class Printer : public DataReaderListener {
  void on_data_available(DataReader* reader) override {
    Bytes sample;
    SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      std::printf("goal %s\n", hex_of(sample).c_str());
      std::fflush(stdout);
    }
  }
};

Topic* make_topic(DomainParticipant& participant, const std::string& name, const std::string& type_name) {
  TypeSupport type(new AnyType(type_name));
  type.register_type(&participant);
  return participant.create_topic(name, type_name, TOPIC_QOS_DEFAULT);
}

DataWriter* make_writer(DomainParticipant& participant, Topic* topic, bool transient) {
  DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = transient ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
  qos.history().kind = KEEP_LAST_HISTORY_QOS;
  qos.history().depth = transient ? 1 : 10;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return participant.create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(topic, qos);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const std::string action = argv[2], type = std::string("control_msgs::action::dds_::") + argv[3];
  DomainParticipant* const participant = DomainParticipantFactory::get_instance()->create_participant(
      static_cast<unsigned>(std::stoi(argv[1])), PARTICIPANT_QOS_DEFAULT);
  if (participant == nullptr) return 1;
  DataWriter* const status = make_writer(
      *participant,
      make_topic(*participant, "rt" + action + "/_action/status", "action_msgs::msg::dds_::GoalStatusArray_"),
      true);
  DataWriter* const feedback = make_writer(
      *participant, make_topic(*participant, "rt" + action + "/_action/feedback", type + "_FeedbackMessage_"),
      false);
  DataReaderQos qos = DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.history().depth = 10;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  Printer printer;
  Topic* const requests =
      make_topic(*participant, "rq" + action + "/_action/send_goalRequest", type + "_SendGoal_Request_");
  DataReader* const reader =
      participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT)->create_datareader(requests, qos, &printer);
  if (status == nullptr || feedback == nullptr || reader == nullptr) return 1;
  std::printf("ready\n");
  std::fflush(stdout);
  for (std::string word, hex; std::cin >> word >> hex;) {
    Bytes bytes = bytes_of(hex);
    if (!(word == "status" ? status : feedback)->write(&bytes)) return 1;
  }
  reader->set_listener(nullptr);
  participant->delete_contained_entities();
  DomainParticipantFactory::get_instance()->delete_participant(participant);
  return 0;
}
