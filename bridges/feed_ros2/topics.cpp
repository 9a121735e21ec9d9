#include "bridges/feed_ros2/topics.hpp"

#include "bridges/feed_ros2/topic_reader.hpp"

namespace slipd::feed_ros2 {

Topics::Topics(const Settings& settings, bridges::Loop& loop)
    : teller_(loop, lanes_),
      node_(settings.node),
      host_(loop, settings.node),
      publications_(node_),
      ending_(dds_create_guardcondition(node_.participant())),
      waiting_(dds_create_waitset(node_.participant())) {
  if (ending_ < 0 || waiting_ < 0) throw ros2::DdsError("wait set of DDS: is there memory?");
  dds_waitset_attach(waiting_, ending_, 0);
  dds_waitset_attach(waiting_, publications_.entity(), 0);
  for (const FeedSettings& feed : settings.feeds) {
    lanes_.push_back(std::make_unique<feed::Lane>(
        feed.sensor, feed.profile.frames, std::make_unique<TopicReader>(feed.profile), settings.socket));
    topics_.push_back(std::make_unique<Topic>(node_, feed.profile, *lanes_.back()));
    dds_waitset_attach(waiting_, topics_.back()->entity(), 0);
  }
  node_.announce();
  reader_ = std::thread([this] { read(); });
}

Topics::~Topics() {
  dds_set_guardcondition(ending_, true);
  reader_.join();
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
