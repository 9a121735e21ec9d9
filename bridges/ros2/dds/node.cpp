#include "bridges/ros2/dds/node.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "bridges/ros2/dds/host_network.hpp"

namespace slipd::ros2 {
namespace {

// How long a write may wait for a reader, ns: not at all, as samples that do not fit replace older ones.
constexpr dds_duration_t kNoWaiting = 0;
// Participants of one computer that find each other without multicast. DDS' port numbers allow 120 a domain.
constexpr int kMostLocalParticipants = 99;

dds_entity_t made(dds_entity_t entity, const std::string& what, const std::string& remedy) {
  if (entity < 0) throw DdsError(what + ": " + dds_strretcode(entity) + "; " + remedy);
  return entity;
}

bool host_only(const NodeOptions& options) {
  return options.interfaces == std::vector<std::string>{kHost};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<' || c == '&' || c == '"') {
      out += "&#" + std::to_string(static_cast<int>(c)) + ";";
    } else {
      out += c;
    }
  }
  return out;
}

// `multicast`: also on an interface that says that it has none.
std::string interface_element(const std::string& name, bool multicast) {
  const bool address = name.find_first_of(".:") != std::string::npos;
  return std::string("<NetworkInterface ") + (address ? "address" : "name") + "=\"" + escaped(name) + "\"" +
         (multicast ? " multicast=\"true\"" : "") + "/>";
}

// Cyclone's configuration. It replaces what the environment's CYCLONEDDS_URI says, so that the settings file
// holds.
std::string configuration(const NodeOptions& options) {
  std::string interfaces, multicast;
  if (host_only(options)) {
    // One without multicast would end it on all. The kernel has it on loopback, too.
    for (const HostInterface& one : host_interfaces()) interfaces += interface_element(one.name, true);
    multicast = "<AllowMulticast>spdp</AllowMulticast><MulticastTimeToLive>0</MulticastTimeToLive>";
  } else {
    for (const std::string& name : options.interfaces) interfaces += interface_element(name, false);
    multicast =
        std::string("<AllowMulticast>") + (options.multicast ? "true" : "false") + "</AllowMulticast>";
  }
  std::string peers;
  for (const std::string& peer : options.peers) peers += "<Peer address=\"" + escaped(peer) + "\"/>";
  return "<CycloneDDS><Domain Id=\"any\"><General>" +
         (interfaces.empty() ? "" : "<Interfaces>" + interfaces + "</Interfaces>") + multicast +
         "</General><Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>" +
         std::to_string(kMostLocalParticipants) + "</MaxAutoParticipantIndex>" +
         (peers.empty() ? "" : "<Peers>" + peers + "</Peers>") + "</Discovery></Domain></CycloneDDS>";
}

struct DeleteListener {
  void operator()(dds_listener_t* listener) const noexcept { dds_delete_listener(listener); }
};

struct DeleteQos {
  void operator()(dds_qos_t* qos) const noexcept { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, DeleteQos>;

Qos make_qos() {
  return Qos(dds_create_qos());
}

void set_user_data(dds_qos_t& qos, const std::string& text) {
  dds_qset_userdata(&qos, text.data(), text.size());
}

template <std::size_t BYTES>
Gid<BYTES> gid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  Gid<BYTES> gid;
  std::copy(std::begin(guid.v), std::end(guid.v), gid.data.begin());
  return gid;
}

}  // namespace

Node::Node(const NodeOptions& options, std::function<void()> readers_changed)
    : options_(options),
      readers_changed_(std::move(readers_changed)),
      domain_(made(
          dds_create_domain(options.domain, configuration(options).c_str()), "DDS domain",
          "see `network` in the settings: the interfaces must exist, and have multicast if that is on")) {
  try {
    if (host_only(options) && !receive_from_host_only(options.domain))
      throw DdsError(
          "DDS domain: the kernel does not limit its sockets to this computer, as Linux 5.7 and later do; "
          "give "
          "`network`.`interfaces` the name of an interface, such as lo, in the settings");
    const Qos qos = make_qos();
    // ROS 2 counts a participant with an enclave among its own.
    set_user_data(*qos, "enclave=/;");
    participant_ =
        made(dds_create_participant(options.domain, qos.get(), nullptr), "DDS participant",
             "is the network interface up, and are there fewer than 100 participants on this computer?");
    const WriterOptions last{.depth = 1, .reliable = true};
    if (options.humble) {
      using Type = DdsType<ParticipantEntitiesInfo<kHumbleGidBytes>>;
      // The type of Humble under the name that both have.
      const std::string name = dds_name(ParticipantEntitiesInfo<kHumbleGidBytes>::kName);
      discovery_ = make_writer(renamed(Type::descriptor(), name.c_str()), "ros_discovery_info", {}, last,
                               true, nullptr);
    } else {
      using Info = ParticipantEntitiesInfo<kGidBytes>;
      discovery_ = make_writer(DdsType<Info>::descriptor(), "ros_discovery_info", Info::kTypeHash, last, true,
                               nullptr);
    }
    announce();
  } catch (...) {
    dds_delete(domain_);
    throw;
  }
}

Node::~Node() {
  dds_delete(domain_);  // and all that is in it
}

dds_entity_t Node::make_writer(const dds_topic_descriptor_t& type, const std::string& topic,
                               std::string_view hash, const WriterOptions& options, bool transient,
                               Readers* readers) {
  const std::string remedy = "is another program of this computer using the domain in this process?";
  const Qos qos = make_qos();
  dds_qset_reliability(qos.get(), options.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kNoWaiting);
  dds_qset_durability(qos.get(), transient ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, options.depth);
  if (options.deadline.count() > 0) dds_qset_deadline(qos.get(), options.deadline.count());
  // Asserted by hand: Cyclone's own threads go on while the program that makes the samples hangs.
  if (options.lease.count() > 0)
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, options.lease.count());
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &representation);
  if (!hash.empty()) set_user_data(*qos, "typehash=RIHS01_" + std::string(hash) + ";");
  const dds_entity_t entity =
      made(dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr), "topic " + topic, remedy);
  const std::unique_ptr<dds_listener_t, DeleteListener> listener(dds_create_listener(readers));
  if (readers != nullptr) {
    readers->changed_ = &readers_changed_;
    dds_lset_publication_matched_arg(listener.get(), &Node::count_readers, readers, true);
  }
  const dds_entity_t writer = dds_create_writer(participant_, entity, qos.get(), listener.get());
  dds_delete(entity);  // the writer keeps it
  return made(writer, "writer of " + topic, remedy);
}

dds_entity_t Node::add_writer(const dds_topic_descriptor_t& type, std::string_view topic,
                              std::string_view hash, const WriterOptions& options, Readers& readers) {
  const dds_entity_t writer =
      make_writer(type, std::string(options.prefix) + std::string(topic),
                  options_.humble ? std::string_view() : hash, options, false, &readers);
  writers_.push_back(writer);
  return writer;
}

dds_entity_t Node::add_reader(const dds_topic_descriptor_t& type, std::string_view topic,
                              std::string_view hash, const ReaderOptions& options) {
  const std::string name = "rt" + std::string(topic);
  const Qos qos = make_qos();
  dds_qset_reliability(qos.get(), options.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kNoWaiting);
  dds_qset_durability(qos.get(),
                      options.transient ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, options.depth);
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &representation);
  if (!hash.empty() && !options_.humble) set_user_data(*qos, "typehash=RIHS01_" + std::string(hash) + ";");
  const dds_entity_t entity = made(dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr),
                                   "topic " + name, "have two feeds the topic with different types?");
  const dds_entity_t reader = dds_create_reader(participant_, entity, qos.get(), nullptr);
  dds_delete(entity);  // the reader keeps it
  readers_.push_back(made(reader, "subscription of " + name, "is there memory?"));
  return reader;
}

void Node::remove_reader(dds_entity_t reader) noexcept {
  std::erase(readers_, reader);
  dds_delete(reader);
}

// Cyclone ends calls of it before it deletes the writer.
void Node::count_readers(dds_entity_t /*writer*/, dds_publication_matched_status_t status, void* readers) {
  auto& of = *static_cast<Readers*>(readers);
  of.count_.store(status.current_count, std::memory_order_relaxed);
  if (*of.changed_) (*of.changed_)();
}

void Node::remove_writer(dds_entity_t writer) noexcept {
  std::erase(writers_, writer);
  dds_delete(writer);
}

void Node::announce() {
  if (options_.humble) {
    write_entities<kHumbleGidBytes>();
  } else {
    write_entities<kGidBytes>();
  }
}

template <std::size_t BYTES>
void Node::write_entities() {
  ParticipantEntitiesInfo<BYTES> info;
  info.gid = gid_of<BYTES>(participant_);
  NodeEntitiesInfo<BYTES>& node = info.node_entities_info_seq.emplace_back();
  node.node_namespace.text = options_.name_space;
  node.node_name.text = options_.name;
  for (const dds_entity_t writer : writers_) node.writer_gid_seq.push_back(gid_of<BYTES>(writer));
  for (const dds_entity_t reader : readers_) node.reader_gid_seq.push_back(gid_of<BYTES>(reader));
  typename DdsType<ParticipantEntitiesInfo<BYTES>>::Sample sample{};
  SampleMemory memory;
  DdsType<ParticipantEntitiesInfo<BYTES>>::fill(info, sample, memory);
  dds_write(discovery_, &sample);
}

}  // namespace slipd::ros2
