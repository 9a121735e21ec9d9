#include "bridges/web/settings.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace slipd::web {
namespace {

constexpr std::size_t kShortestToken = 16, kLongestToken = 256;

}  // namespace

Settings settings_from(const nlohmann::json& json) {
  Settings settings;
  settings.slipd_socket = json.at("slipd").at("socket");
  settings.max_age_ms = json.at("slipd").at("max_age_ms");
  settings.address = json.at("listen").at("address");
  settings.port = json.at("listen").at("port");
  settings.hosts = json.at("hosts").get<std::vector<std::string>>();
  settings.token_file = json.at("token_file");
  settings.recordings = json.at("recordings");
  settings.max_browsers = json.at("max_browsers");
  settings.max_rate_hz = json.at("max_rate_hz");
  return settings;
}

std::vector<Problem> further_problems(const nlohmann::json& json) {
  const nlohmann::json& address = json.at("listen").at("address");
  boost::system::error_code error;
  const auto parsed = boost::asio::ip::make_address(address.get<std::string>(), error);
  if (error) return {problem_of("/listen/address", address, "is no IP address; write one such as 127.0.0.1")};
  if (!parsed.is_loopback() && json.at("token_file").get<std::string>().empty())
    return {
        problem_of("/listen/address", address,
                   "others could look on: set token_file, or listen on 127.0.0.1 behind a reverse proxy")};
  return {};
}

std::string read_token(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw std::runtime_error(file + ": cannot be read; token_file names a file that slipd-web may read");
  std::string token;
  std::getline(in, token);
  if (!token.empty() && token.back() == '\r') token.pop_back();
  const bool plain = std::all_of(token.begin(), token.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
  if (!plain || token.size() < kShortestToken || token.size() > kLongestToken)
    throw std::runtime_error(file +
                             ": the first line must be the token, 16 to 256 letters, digits, - and _; "
                             "make one: openssl rand -hex 24");
  return token;
}

}  // namespace slipd::web
