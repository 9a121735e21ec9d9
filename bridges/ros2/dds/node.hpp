// A ROS 2 node by DDS alone: a participant that ROS 2 lists under the node's name, and writers of topics with
// ROS 2's names, types and QoS; subscription.hpp has their readers. Cyclone DDS starts threads of its own.
// Writers and subscriptions may be made and deleted in one thread; writers write in any.
#pragma once

#include <dds/dds.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/dds/samples.hpp"
#include "bridges/ros2/messages/definition.hpp"

namespace slipd::ros2 {

// what() says what failed and what to do.
class DdsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct NodeOptions {
  // ROS_DOMAIN_ID of the nodes that are to see this one, 0 to 101.
  unsigned domain = 0;
  // Names or addresses of network interfaces; empty: Cyclone's choice of one; "host" alone: this computer
  // only (host_network.hpp), for which `multicast` does not apply.
  std::vector<std::string> interfaces{"host"};
  // Whether to find others and send to many by multicast. The loopback interface usually has none.
  bool multicast = false;
  // Hosts that are asked by unicast.
  std::vector<std::string> peers{"127.0.0.1"};
  // The node's name and namespace, as ROS 2 shows them.
  std::string name = "slipd";
  std::string name_space = "/";
  // Of Humble and before: identifiers of 24 bytes in ros_discovery_info, and no type hashes.
  bool humble = false;
};

// QoS of a writer.
struct WriterOptions {
  // Samples kept for readers that have not yet acknowledged them, or for lost ones to be sent again, 1 or
  // more. Too few: a reader that is slow for a moment loses samples. More: memory.
  int depth = 10;
  // Whether lost samples are sent again.
  bool reliable = true;
  // What DDS has in front of the topic's name: rt, or rq of a service's requests.
  std::string_view prefix = "rt";
  // Longest time between two samples that is offered; 0: none is. Readers that ask for this, for more, or for
  // none, match. Too short: readers hear of missed deadlines although nothing is wrong.
  std::chrono::nanoseconds deadline{0};
  // How long readers take the writer for alive after a sample or assert_alive(); 0: as long as the node
  // lives. It is offered as manual by topic, so that readers match which ask for this or more, of any kind. A
  // best-effort reader is told by samples only.
  std::chrono::nanoseconds lease{0};
};

// QoS of a subscription.
struct ReaderOptions {
  // Samples kept until they are taken, 1 or more. Too few: a burst loses samples. More: memory.
  int depth = 10;
  // Whether lost samples are asked for again. Best-effort writers do not match then.
  bool reliable = false;
  // Whether samples from before are asked for, too. Writers that do not keep any do not match then.
  bool transient = false;
};

// Which readers a writer has. Cyclone's threads write it.
class Readers {
 public:
  bool any() const noexcept { return count_.load(std::memory_order_relaxed) > 0; }

 private:
  friend class Node;
  // Relaxed: no other memory is read because of it.
  std::atomic<std::uint32_t> count_{0};
  const std::function<void()>* changed_ = nullptr;
};

class Node {
 public:
  // `readers_changed` is called in a thread of Cyclone's when a writer has got or lost a reader; it must not
  // throw nor use the node. Throws DdsError.
  explicit Node(const NodeOptions& options, std::function<void()> readers_changed = {});
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // Cyclone's handle of the participant. Any thread.
  dds_entity_t participant() const noexcept { return participant_; }
  // Tells other nodes which writers and subscriptions there are: after making and after deleting some.
  void announce();

 private:
  template <class T>
  friend class Writer;
  friend class Subscription;

  // `hash`: 64 hexadecimal digits of the type hash; empty: none. `readers` may be null; it must live as long
  // as the writer. Throws DdsError.
  dds_entity_t make_writer(const dds_topic_descriptor_t& type, const std::string& topic,
                           std::string_view hash, const WriterOptions& options, bool transient,
                           Readers* readers);
  dds_entity_t add_writer(const dds_topic_descriptor_t& type, std::string_view topic, std::string_view hash,
                          const WriterOptions& options, Readers& readers);
  static void count_readers(dds_entity_t writer, dds_publication_matched_status_t status, void* readers);
  void remove_writer(dds_entity_t writer) noexcept;
  dds_entity_t add_reader(const dds_topic_descriptor_t& type, std::string_view topic, std::string_view hash,
                          const ReaderOptions& options);
  void remove_reader(dds_entity_t reader) noexcept;
  template <std::size_t BYTES>
  void write_entities();

  NodeOptions options_;
  std::function<void()> readers_changed_;
  dds_entity_t domain_ = 0, participant_ = 0, discovery_ = 0;
  std::vector<dds_entity_t> writers_, readers_;
};

// Of a topic "/slipd/left/margin".
template <class T>
class Writer {
 public:
  // `node` must live longer. Throws DdsError.
  Writer(Node& node, std::string_view topic, const WriterOptions& options)
      : node_(node),
        writer_(node.add_writer(DdsType<T>::descriptor(), topic, T::kTypeHash, options, readers_)) {}
  ~Writer() { node_.remove_writer(writer_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Cyclone's handle. Any thread.
  dds_entity_t entity() const noexcept { return writer_; }
  // Whether there is a reader. Any thread.
  bool has_readers() const noexcept { return readers_.any(); }
  // The writer is alive, though it has nothing to say. Any thread.
  void assert_alive() const noexcept { dds_assert_liveliness(writer_); }
  // Sends a message to all readers. False: Cyclone has not taken it.
  bool write(const T& message) const {
    typename DdsType<T>::Sample sample{};
    SampleMemory memory;
    DdsType<T>::fill(message, sample, memory);
    return dds_write(writer_, &sample) == DDS_RETCODE_OK;
  }

 private:
  Node& node_;
  Readers readers_;
  dds_entity_t writer_;
};

}  // namespace slipd::ros2
