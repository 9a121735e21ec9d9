// slipd-feed itself: a lane for each sensor, the sources that they read, and the log. Sources
// run in a thread of their own, frames go to slipd in one for each sensor, and the loop's thread tells.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <thread>
#include <vector>

#include "bridges/feed/settings.hpp"
#include "bridges/feed/udp_source.hpp"
#include "bridges/feed/websocket_source.hpp"
#include "bridges/feed_lane/lane.hpp"
#include "bridges/feed_lane/teller.hpp"
#include "bridges/support/program.hpp"

namespace slipd::feed {

class Feeds : public bridges::Service {
 public:
  // Throws std::exception if a port cannot be listened on.
  Feeds(const Settings& settings, bridges::Loop& loop);
  ~Feeds() override;

 private:
  void listen(const Settings& settings);

  std::vector<std::unique_ptr<Lane>> lanes_;
  Teller teller_;
  boost::asio::io_context context_;
  std::vector<std::unique_ptr<UdpSource>> ports_;
  std::vector<std::unique_ptr<WebSocketSource>> servers_;
  std::thread sources_;
};

}  // namespace slipd::feed
