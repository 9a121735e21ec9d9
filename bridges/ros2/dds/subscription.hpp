// What other nodes publish on a topic, as bytes: dds_takecdr() gives samples in the order in which they came,
// and slipd's own decoder (messages/cdr.hpp) reads them, as it reads recordings. One thread's own.
//
// Cyclone checks the bytes against the type before: what is no message of it never comes here
// (cyclone_log.hpp).
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/dds/node.hpp"

namespace slipd::ros2 {

struct TakenSample {
  std::span<const std::uint8_t> cdr;    // with its encapsulation header
  std::optional<std::int64_t> sent_ns;  // on the publisher's clock
  dds_instance_handle_t publisher = 0;
};

class Subscription {
 public:
  // `topic`: "/left/taxels". `node` must live longer. Throws DdsError.
  template <class T>
  static Subscription of(Node& node, std::string topic, const ReaderOptions& options) {
    return {node, DdsType<T>::descriptor(), std::move(topic), T::kTypeHash, options};
  }
  ~Subscription();
  Subscription(Subscription&& other) noexcept;
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;
  Subscription& operator=(Subscription&&) = delete;

  // Cyclone's handle, for wait sets: triggered by samples, losses and publishers that come and go.
  dds_entity_t entity() const noexcept { return reader_; }
  // Hands out what has come.
  void take(const std::function<void(const TakenSample&)>& hand_out);
  // Samples that DDS has lost since the last call.
  std::uint64_t lost();
  // Whether a publisher that matches has come or gone since the last call.
  bool publishers_changed();
  // The publishers that match, at the moment.
  std::vector<dds_instance_handle_t> publishers() const;

 private:
  friend class Publications;
  Subscription(Node& node, const dds_topic_descriptor_t& type, std::string topic, std::string_view hash,
               const ReaderOptions& options);

  Node* node_;
  std::string topic_, type_;
  bool reliable_;
  dds_entity_t reader_;
};

// All publishers in the domain, also those that do not match a subscription. One thread's own.
class Publications {
 public:
  // Throws DdsError.
  explicit Publications(Node& node);
  ~Publications();
  Publications(const Publications&) = delete;
  Publications& operator=(const Publications&) = delete;

  // For wait sets: triggered when a publisher comes or goes.
  dds_entity_t entity() const noexcept { return reader_; }
  // Whether one has come or gone since the last call.
  bool changed();
  // For people: why nothing can come; empty: there is a publisher that matches.
  std::string trouble(const Subscription& subscription) const;

 private:
  dds_entity_t reader_;
};

}  // namespace slipd::ros2
