// ros2-watcher SOCKET SENSOR DOMAIN SECONDS DEPTH LEAF…: subscribes to a sensor's estimates on slipd's socket
// and on the topics margin, wrench or estimate at the same time, and prints one JSON object: for the socket
// and each topic the samples, those lost between the first and the last, the latencies from the estimate and
// how much later or earlier than its predecessor a sample came than it was made. DEPTH is that of the
// readers' history; 10 is rclcpp's. The names of topics are those of slipd-ros2's default prefix.
#include <dds/dds.h>
#include <poll.h>
#include <slipd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bridges/support/clock.hpp"
#include "ros2.h"  // made by idlc

namespace {

using Json = nlohmann::json;
using slipd::bridges::monotonic_ns;
using slipd::bridges::realtime_ns;

constexpr std::int64_t kMsNs = 1'000'000, kSecondNs = 1'000'000'000;
// For what hangs.
constexpr std::int64_t kPatienceNs = 300 * kSecondNs;
// After the last estimate, so that its messages arrive.
constexpr std::int64_t kRestNs = 300 * kMsNs;
// The socket is older than any estimate: losses are judged from what slipd sent.
constexpr double kAnyAge = 1e6;
// Stamps are rounded and two clocks are read one after the other. Estimates are at least 0.5 ms apart.
constexpr std::int64_t kSameStampNs = 200'000;

const char* const kConfiguration =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers>"
    "</Discovery></Domain></CycloneDDS>";

// An estimate as the socket had it.
struct Estimate {
  std::uint64_t sequence;
  std::int64_t sample_ns, made_ns, arrived_ns;  // CLOCK_MONOTONIC
  float gamma;
};

// A message of a topic.
struct Sample {
  std::int64_t arrived_ns = 0, stamp_ns = 0, written_ns = 0;  // CLOCK_MONOTONIC
  std::uint64_t sequence = 0;
  float value = NAN;
};

struct Topic {
  std::string leaf;
  dds_entity_t reader = 0;
  std::mutex mutex;
  std::vector<Sample> samples;
};

std::int64_t nanoseconds(const std_msgs_msg_dds__Header_& header) {
  return kSecondNs * header.stamp.sec + header.stamp.nanosec;
}

Sample read_sample(const std::string& leaf, const void* data, std::int64_t ahead_ns) {
  Sample sample;
  if (leaf == "margin") sample.value = static_cast<const std_msgs_msg_dds__Float32_*>(data)->data;
  if (leaf == "wrench")
    sample.stamp_ns =
        nanoseconds(static_cast<const geometry_msgs_msg_dds__WrenchStamped_*>(data)->header) - ahead_ns;
  if (leaf == "estimate") {
    const auto& estimate = *static_cast<const slipd_msgs_msg_dds__SlipEstimate_*>(data);
    sample.stamp_ns = nanoseconds(estimate.header) - ahead_ns;
    sample.sequence = estimate.seq;
  }
  return sample;
}

// In a thread of Cyclone's.
void take(dds_entity_t reader, void* arg) {
  auto& topic = *static_cast<Topic*>(arg);
  const std::int64_t now_ns = monotonic_ns(), ahead_ns = realtime_ns() - now_ns;
  constexpr int kMost = 16;
  void* data[kMost] = {};
  dds_sample_info_t info[kMost];
  for (;;) {
    const int taken = dds_take(reader, data, info, kMost, kMost);
    if (taken <= 0) return;
    const std::lock_guard lock(topic.mutex);
    for (int i = 0; i < taken; ++i) {
      if (!info[i].valid_data) continue;
      Sample sample = read_sample(topic.leaf, data[i], ahead_ns);
      sample.arrived_ns = now_ns;
      sample.written_ns = info[i].source_timestamp - ahead_ns;
      topic.samples.push_back(sample);
    }
    dds_return_loan(reader, data, taken);
  }
}

bool start(Topic& topic, dds_entity_t participant, const std::string& sensor, int depth) {
  const dds_topic_descriptor_t* const type = topic.leaf == "margin" ? &std_msgs_msg_dds__Float32__desc
                                             : topic.leaf == "wrench"
                                                 ? &geometry_msgs_msg_dds__WrenchStamped__desc
                                                 : &slipd_msgs_msg_dds__SlipEstimate__desc;
  const std::string name = "rt/slipd/" + sensor + "/" + topic.leaf;
  const dds_entity_t entity = dds_create_topic(participant, type, name.c_str(), nullptr, nullptr);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  dds_listener_t* const listener = dds_create_listener(&topic);
  dds_lset_data_available(listener, &take);
  topic.reader = dds_create_reader(participant, entity, qos, listener);
  dds_delete_listener(listener);
  dds_delete_qos(qos);
  return topic.reader > 0;
}

std::vector<Estimate> estimates;
std::uint64_t dropped = 0;

void note(slipd_client* client, const slipd_estimate& estimate) {
  const std::int64_t now_ns = monotonic_ns();
  const Json text = Json::parse(slipd_event_text(client));
  const double latency_us = text.at("latency_us").is_number() ? text.at("latency_us").get<double>() : 0;
  dropped += estimate.dropped;
  estimates.push_back({estimate.sequence, estimate.time_ns,
                       estimate.time_ns + static_cast<std::int64_t>(1e3 * latency_us), now_ns,
                       static_cast<float>(estimate.gamma)});
}

// Reads the socket until `until_ns`. False: slipd is away.
bool read_socket(slipd_client* client, std::int64_t until_ns) {
  while (monotonic_ns() < until_ns) {
    pollfd ready{slipd_fd(client), POLLIN, 0};
    poll(&ready, 1, static_cast<int>((until_ns - monotonic_ns()) / kMsNs) + 1);
    slipd_estimate estimate;
    int code = SLIPD_DONE;
    while ((code = slipd_next(client, kAnyAge, 0, &estimate)) == SLIPD_DONE) note(client, estimate);
    if (code < 0) return false;
  }
  return true;
}

bool same(float a, float b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

// Which estimate a message is of; estimates.size(): none of them. `from`: a place in them before which it is
// not.
std::size_t estimate_of(const Topic& topic, const Sample& sample, std::size_t from) {
  const auto begin = estimates.begin() + static_cast<std::ptrdiff_t>(from);
  auto found = estimates.end();
  if (topic.leaf == "estimate") {
    found = std::find_if(begin, estimates.end(),
                         [&](const Estimate& one) { return one.sequence >= sample.sequence; });
    if (found != estimates.end() && found->sequence != sample.sequence) found = estimates.end();
  } else if (topic.leaf == "wrench") {
    found = std::find_if(begin, estimates.end(),
                         [&](const Estimate& one) { return one.sample_ns > sample.stamp_ns - kSameStampNs; });
    if (found != estimates.end() && found->sample_ns > sample.stamp_ns + kSameStampNs)
      found = estimates.end();
  } else {
    found = begin;  // margins have neither time nor number: they are counted, and compared
  }
  return static_cast<std::size_t>(found - estimates.begin());
}

Json quantiles(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double part) {
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  };
  return {{"p50", at(0.5)}, {"p99", at(0.99)}, {"p999", at(0.999)}, {"max", values.back()}};
}

// `pairs`: an estimate's place in `estimates`, and when it arrived here.
Json report(const std::vector<std::pair<std::size_t, std::int64_t>>& pairs) {
  std::vector<double> latencies, jitters;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [place, arrived_ns] = pairs[i];
    latencies.push_back(1e-3 * static_cast<double>(arrived_ns - estimates[place].made_ns));
    if (i == 0) continue;
    const auto [last, last_arrived_ns] = pairs[i - 1];
    jitters.push_back(1e-3 *
                      std::abs(static_cast<double>((arrived_ns - last_arrived_ns) -
                                                   (estimates[place].made_ns - estimates[last].made_ns))));
  }
  return {{"samples", pairs.size()}, {"latency_us", quantiles(latencies)}, {"jitter_us", quantiles(jitters)}};
}

// The place of the estimate that the first margin is of: the one at which most of the margins that follow are
// those of the estimates, among those made before it was written.
std::size_t first_of_margins(const Topic& topic) {
  constexpr std::size_t kBack = 200, kCompared = 200;
  if (topic.samples.empty()) return 0;
  const auto after = std::find_if(estimates.begin(), estimates.end(), [&](const Estimate& one) {
    return one.made_ns > topic.samples.front().written_ns;
  });
  const auto newest = static_cast<std::size_t>(after - estimates.begin());
  std::size_t best = 0, most = 0;
  for (std::size_t place = newest > kBack ? newest - kBack : 0; place < newest; ++place) {
    std::size_t equal = 0;
    for (std::size_t i = 0; i < std::min({kCompared, topic.samples.size(), estimates.size() - place}); ++i)
      equal += same(topic.samples[i].value, estimates[place + i].gamma) ? 1U : 0U;
    if (equal < most) continue;
    most = equal;
    best = place;
  }
  return best;
}

Json judge(Topic& topic) {
  std::vector<std::pair<std::size_t, std::int64_t>> pairs;
  std::size_t from = topic.leaf == "margin" ? first_of_margins(topic) : 0, foreign = 0, different = 0;
  for (const Sample& sample : topic.samples) {
    const std::size_t place = estimate_of(topic, sample, from);
    if (place >= estimates.size()) {
      ++foreign;
      continue;
    }
    if (topic.leaf == "margin" && !same(sample.value, estimates[place].gamma)) ++different;
    pairs.emplace_back(place, sample.arrived_ns);
    from = place + 1;
  }
  Json result = report(pairs);
  const std::size_t sent = pairs.empty() ? 0 : pairs.back().first - pairs.front().first + 1;
  dds_sample_lost_status_t lost{};
  dds_get_sample_lost_status(topic.reader, &lost);
  result["lost"] = sent - pairs.size();
  result["lost_by_cyclone"] = lost.total_count;
  result["foreign"] = foreign;
  if (topic.leaf == "margin") result["different"] = different;
  return result;
}

bool all_have_samples(std::vector<std::unique_ptr<Topic>>& topics) {
  return std::all_of(topics.begin(), topics.end(), [](const auto& topic) {
    const std::lock_guard lock(topic->mutex);
    return !topic->samples.empty();
  });
}

int fail(const char* what) {
  std::fprintf(stderr, "ros2-watcher: %s\n", what);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return fail("SOCKET SENSOR DOMAIN SECONDS DEPTH [LEAF…]");
  const auto domain = static_cast<unsigned>(std::atoi(argv[3]));
  const auto seconds_ns = static_cast<std::int64_t>(1e9 * std::atof(argv[4]));
  slipd_client* client = nullptr;
  if (slipd_open(&client, argv[1]) != SLIPD_DONE ||
      slipd_subscribe(client, argv[2], 0, SLIPD_EVENT_ESTIMATE, 10) != SLIPD_DONE)
    return fail(slipd_error_text(client));
  // With CYCLONEDDS_URI, say empty for what a ROS 2 node has by default, the environment configures Cyclone.
  if (std::getenv("CYCLONEDDS_URI") == nullptr && dds_create_domain(domain, kConfiguration) < 0)
    return fail("no domain");
  const char* const others = std::getenv("PARTICIPANTS");
  for (int i = 0; others != nullptr && i < std::atoi(others); ++i) {
    if (dds_create_participant(domain, nullptr, nullptr) < 0) return fail("no participant");
  }
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  std::vector<std::unique_ptr<Topic>> topics;
  for (int i = 6; i < argc; ++i) {
    topics.push_back(std::make_unique<Topic>());
    topics.back()->leaf = argv[i];
    if (!start(*topics.back(), participant, argv[2], std::atoi(argv[5]))) return fail("no reader");
  }
  const std::int64_t give_up_ns = monotonic_ns() + kPatienceNs;
  while (!all_have_samples(topics)) {
    if (!read_socket(client, monotonic_ns() + 10 * kMsNs)) return fail(slipd_error_text(client));
    if (monotonic_ns() > give_up_ns) return fail("a topic brings no message");
  }
  if (!read_socket(client, monotonic_ns() + seconds_ns)) return fail(slipd_error_text(client));
  for (const auto& topic : topics) dds_set_listener(topic->reader, nullptr);
  if (!read_socket(client, monotonic_ns() + kRestNs)) return fail(slipd_error_text(client));
  std::vector<std::pair<std::size_t, std::int64_t>> pairs;
  for (std::size_t i = 0; i < estimates.size(); ++i) pairs.emplace_back(i, estimates[i].arrived_ns);
  Json result = {{"socket", report(pairs)}};
  result["socket"]["lost"] = dropped;
  for (const auto& topic : topics) result[topic->leaf] = judge(*topic);
  std::printf("%s\n", result.dump().c_str());
  slipd_close(client);
  dds_delete(DDS_CYCLONEDDS_HANDLE);  // otherwise the writers keep its readers until their lease ends
  return 0;
}
