#include "bridges/feed/feeds.hpp"

#include <systemd/sd-daemon.h>

#include <boost/system/system_error.hpp>
#include <chrono>
#include <map>
#include <stdexcept>
#include <utility>

#include "bridges/feed/report.hpp"
#include "bridges/support/log.hpp"

namespace slipd::feed {
namespace {

constexpr std::chrono::seconds kReportPeriod{2};

}  // namespace

Feeds::Feeds(const Settings& settings, bridges::Loop& loop) : report_(loop, [this] { tell(); }) {
  for (const FeedSettings& feed : settings.feeds)
    lanes_.push_back(std::make_unique<Lane>(feed.sensor, feed.profile, settings.socket));
  told_.resize(lanes_.size());
  listen(settings);
  sources_ = std::thread([this] { context_.run(); });
  report_.start(kReportPeriod);
  if (lanes_.empty()) bridges::log(bridges::LogLevel::warning, "the settings have no feeds: nothing to do");
}

Feeds::~Feeds() {
  context_.stop();
  sources_.join();
  for (const auto& lane : lanes_)
    bridges::log(bridges::LogLevel::info, summary(lane->sensor(), lane->account()));
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
    ports[{feed.from.host, feed.from.port}].push_back({lanes_[i].get(), std::move(assembler), feed.sender});
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

void Feeds::tell() {
  std::string status;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    Account now = lanes_[i]->account();
    for (const Line& line : report(lanes_[i]->sensor(), told_[i], now)) bridges::log(line.level, line.text);
    status += (status.empty() ? "" : "; ") + lanes_[i]->sensor() + " " +
              std::to_string(now.sent - told_[i].sent) + " frames";
    told_[i] = std::move(now);
  }
  sd_notifyf(0, "STATUS=In the last %d s: %s", static_cast<int>(kReportPeriod.count()), status.c_str());
  report_.start(kReportPeriod);
}

}  // namespace slipd::feed
