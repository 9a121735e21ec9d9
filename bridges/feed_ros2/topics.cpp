#include "bridges/feed_ros2/topics.hpp"

#include "bridges/feed_ros2/topic_reader.hpp"

namespace slipd::feed_ros2 {
namespace {

std::vector<std::unique_ptr<feed::Lane>> lanes_for(const Settings& settings) {
  std::vector<std::unique_ptr<feed::Lane>> lanes;
  for (const FeedSettings& feed : settings.feeds)
    lanes.push_back(std::make_unique<feed::Lane>(
        feed.sensor, feed.profile.frames, std::make_unique<TopicReader>(feed.profile), settings.socket));
  return lanes;
}

std::multimap<std::string, feed::Lane*, std::less<>> by_topic(
    const Settings& settings, const std::vector<std::unique_ptr<feed::Lane>>& lanes) {
  std::multimap<std::string, feed::Lane*, std::less<>> of;
  for (std::size_t i = 0; i < lanes.size(); ++i) of.emplace(settings.feeds[i].profile.topic, lanes[i].get());
  return of;
}

}  // namespace

Topics::Topics(const Settings& settings, bridges::Loop& loop)
    : lanes_(lanes_for(settings)),
      teller_(loop, lanes_),
      lanes_of_(by_topic(settings, lanes_)),
      cyclone_([this](std::string_view topic) { return refuse(topic); }),
      node_(settings.node),
      host_(loop, settings.node),
      publications_(node_),
      ending_(dds_create_guardcondition(node_.participant())),
      waiting_(dds_create_waitset(node_.participant())) {
  if (ending_ < 0 || waiting_ < 0) throw ros2::DdsError("wait set of DDS: is there memory?");
  dds_waitset_attach(waiting_, ending_, 0);
  dds_waitset_attach(waiting_, publications_.entity(), 0);
  for (std::size_t i = 0; i < settings.feeds.size(); ++i) {
    topics_.push_back(std::make_unique<Topic>(node_, settings.feeds[i].profile, *lanes_[i]));
    dds_waitset_attach(waiting_, topics_.back()->entity(), 0);
  }
  node_.announce();
  reader_ = std::thread([this] { read(); });
}

Topics::~Topics() {
  dds_set_guardcondition(ending_, true);
  reader_.join();
}

// Cyclone's threads.
bool Topics::refuse(std::string_view topic) {
  const auto [begin, end] = lanes_of_.equal_range(topic);
  for (auto lane = begin; lane != end; ++lane)
    lane->second->refuse("its bytes are no message of the topic's type");
  return begin != end;
}

void Topics::read() {
  bool ending = false, changed = true;
  while (!ending) {
    for (const auto& topic : topics_) topic->serve(publications_, changed);
    dds_waitset_wait(waiting_, nullptr, 0, DDS_INFINITY);
    dds_read_guardcondition(ending_, &ending);
    changed = publications_.changed();
  }
}

}  // namespace slipd::feed_ros2
