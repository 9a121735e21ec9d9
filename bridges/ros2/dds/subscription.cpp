#include "bridges/ros2/dds/subscription.hpp"

#include <dds/ddsi/ddsi_serdata.h>

#include <algorithm>
#include <array>
#include <utility>

namespace slipd::ros2 {
namespace {

constexpr std::uint32_t kAtOnce = 32;
constexpr std::uint32_t kEvents =
    DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS | DDS_SAMPLE_LOST_STATUS;
// Publishers of one topic that are looked at.
constexpr std::size_t kMostPublishers = 64;
// Publishers of a domain that are looked at.
constexpr std::uint32_t kMostPublications = 4096;

}  // namespace

Subscription::Subscription(Node& node, const dds_topic_descriptor_t& type, std::string topic,
                           std::string_view hash, const ReaderOptions& options)
    : node_(&node),
      topic_(std::move(topic)),
      type_(type.m_typename),
      reliable_(options.reliable),
      reader_(node.add_reader(type, topic_, hash, options)) {
  dds_set_status_mask(reader_, kEvents);
}

Subscription::Subscription(Subscription&& other) noexcept
    : node_(other.node_),
      topic_(std::move(other.topic_)),
      type_(std::move(other.type_)),
      reliable_(other.reliable_),
      reader_(std::exchange(other.reader_, 0)) {}

Subscription::~Subscription() {
  if (reader_ > 0) node_->remove_reader(reader_);
}

void Subscription::take(const std::function<void(const TakenSample&)>& hand_out) {
  std::array<ddsi_serdata*, kAtOnce> taken{};
  std::array<dds_sample_info_t, kAtOnce> infos{};
  for (dds_return_t count = kAtOnce; count == static_cast<dds_return_t>(kAtOnce);) {
    count = dds_takecdr(reader_, taken.data(), kAtOnce, infos.data(), DDS_ANY_STATE);
    for (dds_return_t i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const dds_sample_info_t& info = infos.at(at);
      if (info.valid_data) {  // else: that a publisher has gone
        ddsrt_iovec_t bytes{};
        ddsi_serdata* const held =
            ddsi_serdata_to_ser_ref(taken.at(at), 0, ddsi_serdata_size(taken.at(at)), &bytes);
        TakenSample sample{{static_cast<const std::uint8_t*>(bytes.iov_base), bytes.iov_len},
                           std::nullopt,
                           info.publication_handle};
        if (info.source_timestamp > 0 && info.source_timestamp < DDS_NEVER)
          sample.sent_ns = info.source_timestamp;
        hand_out(sample);
        ddsi_serdata_to_ser_unref(held, &bytes);
      }
      ddsi_serdata_unref(taken.at(at));
    }
  }
}

std::uint64_t Subscription::lost() {
  dds_sample_lost_status_t status{};
  dds_get_sample_lost_status(reader_, &status);
  return status.total_count_change > 0 ? static_cast<std::uint64_t>(status.total_count_change) : 0;
}

bool Subscription::publishers_changed() {
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(reader_, &status);
  return status.total_count_change != 0 || status.current_count_change != 0;
}

std::vector<dds_instance_handle_t> Subscription::publishers() const {
  std::vector<dds_instance_handle_t> handles(kMostPublishers);
  const dds_return_t count = dds_get_matched_publications(reader_, handles.data(), handles.size());
  handles.resize(count < 0 ? 0 : std::min(static_cast<std::size_t>(count), handles.size()));
  return handles;
}

Publications::Publications(Node& node)
    : reader_(dds_create_reader(node.participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr)) {
  if (reader_ < 0)
    throw DdsError("list of publishers: " + std::string(dds_strretcode(reader_)) + "; is there memory?");
  dds_set_status_mask(reader_, DDS_DATA_AVAILABLE_STATUS);
}

Publications::~Publications() {
  dds_delete(reader_);
}

bool Publications::changed() {
  std::uint32_t events = 0;
  dds_take_status(reader_, &events, DDS_DATA_AVAILABLE_STATUS);
  return events != 0;
}

std::string Publications::trouble(const Subscription& subscription) const {
  if (!subscription.publishers().empty()) return {};
  const std::string name = "rt" + subscription.topic_;
  std::string why = "no node publishes " + subscription.topic_;
  std::vector<void*> samples(kMostPublications);
  std::vector<dds_sample_info_t> infos(kMostPublications);
  const dds_return_t count =
      dds_read_mask(reader_, samples.data(), infos.data(), kMostPublications, kMostPublications,
                    DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  for (dds_return_t i = 0; i < count; ++i) {
    if (!infos[static_cast<std::size_t>(i)].valid_data) continue;
    const auto& one = *static_cast<const dds_builtintopic_endpoint_t*>(samples[static_cast<std::size_t>(i)]);
    if (one.topic_name == nullptr || name != one.topic_name) continue;
    if (subscription.type_ != one.type_name) {
      why = "a node publishes " + subscription.topic_ + " as " + one.type_name + "; the profile says " +
            subscription.type_;
    } else if (subscription.reliable_) {
      why = "a node publishes " + subscription.topic_ +
            " without reliability: give the profile \"qos\": {\"reliable\": false}";
    } else {
      why = "a node publishes " + subscription.topic_ + " with a quality of service that does not match";
    }
  }
  if (count > 0) dds_return_loan(reader_, samples.data(), count);
  return why;
}

}  // namespace slipd::ros2
