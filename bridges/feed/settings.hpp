// slipd-feed's settings, as feed.schema.json describes them. Any thread that may allocate.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bridges/feed/address.hpp"
#include "bridges/feed/profile.hpp"
#include "schema/schema.hpp"

namespace slipd::feed {

// One sensor.
struct FeedSettings {
  std::string sensor;  // its name in slipd's configuration
  Profile profile;
  Address from;
  std::string sender;  // UDP: address whose datagrams count; empty: all
};

struct Settings {
  std::vector<FeedSettings> feeds;
  std::string socket;  // slipd's
};

// What the schema cannot say: profiles, addresses.
std::vector<Problem> further_problems(const nlohmann::json& settings);

// From settings that have no problems.
Settings settings_of(const nlohmann::json& checked);

}  // namespace slipd::feed
