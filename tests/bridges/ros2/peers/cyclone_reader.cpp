// ros2-cyclone-reader DOMAIN SENSOR: reads a sensor's topics margin, estimate and alert by Cyclone DDS as
// fastdds-reader does with DEADLINE_MS and LEASE_MS in the environment, and prints the same lines, but `-`
// for the writer: `TOPIC - - BYTES`, `TOPIC missed N`, `TOPIC alive N`. Runs until it is killed. Cyclone's
// threads print.
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <vector>

#include "ros2.h"  // made by idlc

namespace {

std::mutex printing;

void on_data(dds_entity_t reader, void* topic) {
  ddsi_serdata* sample = nullptr;
  dds_sample_info_t info{};
  while (dds_takecdr(reader, &sample, 1, &info, DDS_ANY_STATE) == 1) {
    std::vector<unsigned char> bytes(info.valid_data ? ddsi_serdata_size(sample) : 0);
    if (!bytes.empty()) ddsi_serdata_to_ser(sample, 0, bytes.size(), bytes.data());
    ddsi_serdata_unref(sample);
    if (bytes.empty()) continue;
    const std::lock_guard lock(printing);
    std::printf("%s - - ", static_cast<const char*>(topic));
    for (const unsigned char byte : bytes) std::printf("%02x", byte);
    std::printf("\n");
    std::fflush(stdout);
  }
}

void tell(void* topic, const char* what, std::uint32_t number) {
  const std::lock_guard lock(printing);
  std::printf("%s %s %u\n", static_cast<const char*>(topic), what, number);
  std::fflush(stdout);
}

void on_missed(dds_entity_t /*reader*/, dds_requested_deadline_missed_status_t status, void* topic) {
  tell(topic, "missed", status.total_count);
}

void on_alive(dds_entity_t /*reader*/, dds_liveliness_changed_status_t status, void* topic) {
  tell(topic, "alive", status.alive_count);
}

}  // namespace

int main(int argc, char** argv) {
  const char* const deadline_ms = std::getenv("DEADLINE_MS");
  const char* const lease_ms = std::getenv("LEASE_MS");
  if (argc != 3 || deadline_ms == nullptr || lease_ms == nullptr) return 2;
  const dds_entity_t participant =
      dds_create_participant(static_cast<unsigned>(std::atoi(argv[1])), nullptr, nullptr);
  const std::array<std::pair<const char*, const dds_topic_descriptor_t*>, 3> topics{
      {{"margin", &std_msgs_msg_dds__Float32__desc},
       {"estimate", &slipd_msgs_msg_dds__SlipEstimate__desc},
       {"alert", &slipd_msgs_msg_dds__SlipEstimate__desc}}};
  std::array<std::string, topics.size()> names;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const auto [leaf, type] = topics[i];
    names[i] = std::string("/slipd/") + argv[2] + "/" + leaf;
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(std::atoi(lease_ms)));
    if (std::string(leaf) != "alert") dds_qset_deadline(qos, DDS_MSECS(std::atoi(deadline_ms)));
    dds_listener_t* const listener = dds_create_listener(names[i].data());
    dds_lset_data_available(listener, &on_data);
    dds_lset_requested_deadline_missed(listener, &on_missed);
    dds_lset_liveliness_changed(listener, &on_alive);
    const dds_entity_t topic =
        dds_create_topic(participant, type, ("rt" + names[i]).c_str(), nullptr, nullptr);
    if (dds_create_reader(participant, topic, qos, listener) < 0) return 1;
    dds_delete_listener(listener);
    dds_delete_qos(qos);
  }
  for (;;) pause();
}
