#include "bridges/feed/settings.hpp"

#include <nlohmann/json.hpp>

#include "bridges/feed_lane/second_feeds.hpp"
#include "schema/settings_error.hpp"

namespace slipd::feed {
namespace {

using nlohmann::json;

Profile profile_of(const json& feed) {
  return find_profile(feed["profile"], {feed.value("device", ""), feed.value("taxels", std::size_t{0})});
}

void check_address(const json& feed, const std::string& from, const std::string& at,
                   std::vector<Problem>& problems) {
  const auto address = address_of(from);
  if (!address) {
    problems.push_back(
        problem_of(pointer_to(at, "from"), from, "expected udp://ADDRESS:PORT or ws://HOST:PORT/PATH"));
    return;
  }
  if (address->scheme == Scheme::websocket) {
    if (feed.contains("sender"))
      problems.push_back(
          problem_of(pointer_to(at, "sender"), feed["sender"], "is for udp:// only: leave it out"));
    return;
  }
  if (address->host.find_first_not_of("0123456789.") != std::string::npos)
    problems.push_back(problem_of(pointer_to(at, "from"), from,
                                  "expected the IPv4 address to listen on, such as udp://0.0.0.0:9988"));
  if (!address->host.starts_with("127.") && !feed.contains("sender"))
    problems.push_back(problem_of(at, feed,
                                  "every computer that reaches this port could send frames: add \"sender\", "
                                  "the address of the one that may"));
}

void check_feed(const json& feed, const std::string& at, std::vector<Problem>& problems) {
  try {
    const Profile profile = profile_of(feed);
    if (profile.datagrams && !feed.value("from", profile.from).starts_with("udp://"))
      problems.push_back(
          problem_of(pointer_to(at, "from"), feed["from"], "this profile is of datagrams: expected udp://"));
    check_address(feed, feed.value("from", profile.from), at, problems);
  } catch (const SettingsError& error) {
    for (const std::string& problem : error.problems())
      problems.push_back(problem_of(pointer_to(at, "profile"), feed["profile"], problem));
  }
}

}  // namespace

std::vector<Problem> further_problems(const json& settings) {
  std::vector<Problem> problems = second_feeds(settings);
  for (std::size_t i = 0; i < settings["feeds"].size(); ++i) {
    check_feed(settings["feeds"][i], pointer_to("/feeds", i), problems);
  }
  return problems;
}

Settings settings_of(const json& checked) {
  Settings settings;
  settings.socket = checked["socket"];
  for (const json& feed : checked["feeds"]) {
    Profile profile = profile_of(feed);
    const Address from = address_of(feed.value("from", profile.from)).value();
    settings.feeds.push_back({feed["sensor"], std::move(profile), from, feed.value("sender", "")});
  }
  return settings;
}

}  // namespace slipd::feed
