#include "bridges/feed/feeds.hpp"

#include <boost/system/system_error.hpp>
#include <map>
#include <stdexcept>
#include <utility>

#include "bridges/feed/reader.hpp"

namespace slipd::feed {

Feeds::Feeds(const Settings& settings, bridges::Loop& loop) : teller_(loop, lanes_) {
  for (const FeedSettings& feed : settings.feeds)
    lanes_.push_back(std::make_unique<Lane>(feed.sensor, feed.profile.frames,
                                            std::make_unique<Reader>(feed.profile), settings.socket));
  listen(settings);
  sources_ = std::thread([this] { context_.run(); });
}

Feeds::~Feeds() {
  context_.stop();
  sources_.join();
}

void Feeds::listen(const Settings& settings) {
  std::map<std::pair<std::string, std::uint16_t>, std::vector<UdpSource::Listener>> ports;
  for (std::size_t i = 0; i < settings.feeds.size(); ++i) {
    const FeedSettings& feed = settings.feeds[i];
    if (feed.from.scheme == Scheme::websocket) {
      servers_.push_back(std::make_unique<WebSocketSource>(context_, feed.from, *lanes_[i]));
      continue;
    }
    std::optional<Assembler> assembler;
    if (feed.profile.datagrams)
      assembler.emplace(*feed.profile.datagrams, feed.profile.format == Format::yaml_head);
    ports[{feed.from.host, feed.from.port}].push_back(
        {lanes_[i].get(), std::move(assembler), feed.sender, feed.profile.sequence.has_value()});
  }
  for (auto& [at, listeners] : ports) {
    try {
      ports_.push_back(std::make_unique<UdpSource>(context_, Address{Scheme::udp, at.first, at.second, "/"},
                                                   std::move(listeners)));
    } catch (const boost::system::system_error& error) {
      throw std::runtime_error("cannot listen on udp://" + at.first + ":" + std::to_string(at.second) + ": " +
                               error.code().message());
    }
  }
}

}  // namespace slipd::feed
