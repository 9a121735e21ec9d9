// The settings of slipd-web, from its JSON. Any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "schema/schema.hpp"

namespace slipd::web {

struct Settings {
  // slipd's socket.
  std::string slipd_socket;
  // An older frame gives no margin, ms.
  double max_age_ms = 500;
  // IP address to listen on.
  std::string address;
  // TCP port; 0: a free one.
  std::uint16_t port = 8077;
  // Further names that browsers may use for this page.
  std::vector<std::string> hosts;
  // File of the token; empty: none is asked for.
  std::string token_file;
  // Folder of recordings; empty: none.
  std::string recordings;
  // Live pages at a time.
  int max_browsers = 32;
  // Most estimates and pictures a second, Hz.
  double max_rate_hz = 30;
};

// `json` fits the schema.
Settings settings_from(const nlohmann::json& json);

// What the schema cannot state: an address that is none, one beyond this machine without a token.
std::vector<Problem> further_problems(const nlohmann::json& json);

// The token in a file, without the line's end. Throws std::runtime_error for a file that cannot be read, or a
// token of another form.
std::string read_token(const std::string& file);

}  // namespace slipd::web
