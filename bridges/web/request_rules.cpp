#include "bridges/web/request_rules.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace slipd::web {
namespace {

constexpr std::string_view kBearer = "Bearer ";
constexpr std::size_t kLongestTarget = 512;

bool same_letters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// Without its percent escapes; nothing if one is broken.
std::optional<std::string> unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return std::nullopt;
    const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    out += static_cast<char>(16 * high + low);
    i += 2;
  }
  return out;
}

// A file's name: nothing that leads out of its folder or hides.
bool plain_name(std::string_view name) {
  const auto bad = [](unsigned char c) { return c < ' ' || c == 0x7F || c == '/' || c == '\\'; };
  return !name.empty() && name.front() != '.' && std::none_of(name.begin(), name.end(), bad);
}

Route named(Part part, std::string_view escaped) {
  auto name = unescaped(escaped);
  if (!name || !plain_name(*name)) return {};
  return {part, std::move(*name), {}};
}

// "slipd-token-8077=" for 127.0.0.1:8077, "slipd-token=" for a host without a port.
std::string cookie_name(std::string_view host) {
  const std::size_t colon = host.find(':', host.starts_with('[') ? host.find(']') : 0);
  return "slipd-token" + (colon == host.npos ? "" : "-" + std::string(host.substr(colon + 1))) + "=";
}

// The token among "a=b; slipd-token-8077=…"; `name`: with its "=".
std::string_view token_in(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    std::string_view cookie = cookies.substr(0, end);
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    while (!cookie.empty() && cookie.front() == ' ') cookie.remove_prefix(1);
    if (cookie.starts_with(name)) return cookie.substr(name.size());
  }
  return {};
}

}  // namespace

Route route_of(std::string_view target) {
  if (target.empty() || target.front() != '/' || target.size() > kLongestTarget) return {};
  const std::size_t question = target.find('?');
  const std::string_view query = question == target.npos ? std::string_view{} : target.substr(question + 1);
  const std::string_view path = target.substr(1, question == target.npos ? target.npos : question - 1);
  constexpr std::string_view kGiven = "token=", kFolder = "recordings/";
  if (path.empty() && query.starts_with(kGiven))
    return {Part::login, {}, std::string(query.substr(kGiven.size()))};
  if (path.empty()) return {Part::page, "index.html", {}};
  if (path == "live") return {Part::live, {}, {}};
  if (path == "api/recordings") return {Part::recordings, {}, {}};
  if (path == "api/method") return {Part::method, {}, {}};
  if (path == "api/counts") return {Part::counts, {}, {}};
  if (path.starts_with(kFolder)) return named(Part::recording, path.substr(kFolder.size()));
  return named(Part::page, path);
}

RequestRules::RequestRules(std::vector<std::string> hosts, std::string token)
    : hosts_(std::move(hosts)), token_(std::move(token)) {}

bool RequestRules::own_host(std::string_view host) const {
  return std::any_of(hosts_.begin(), hosts_.end(),
                     [&](const std::string& own) { return same_letters(host, own); });
}

bool RequestRules::own_origin(std::string_view origin) const {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme)) return own_host(origin.substr(scheme.size()));
  }
  return false;
}

bool RequestRules::right(std::string_view token) const noexcept {
  unsigned difference = token.size() == token_.size() ? 0U : 1U;
  for (std::size_t i = 0; i < token_.size(); ++i) {
    const char given = token.empty() ? '\0' : token[i % token.size()];
    difference |= static_cast<unsigned char>(given ^ token_[i]);
  }
  return difference == 0;
}

bool RequestRules::admitted(const RequestHead& head) const {
  if (token_.empty()) return true;
  if (head.authorization.starts_with(kBearer)) return right(head.authorization.substr(kBearer.size()));
  return right(token_in(head.cookie, cookie_name(head.host)));
}

std::string RequestRules::cookie(std::string_view host) const {
  return cookie_name(host) + token_;
}

Refusal RequestRules::judge(const RequestHead& head, const Route& route) const {
  if (!own_host(head.host)) return Refusal::host;
  if (head.origin && !own_origin(*head.origin)) return Refusal::origin;
  if (head.method != "GET" && head.method != "HEAD") return Refusal::method;
  if (route.part == Part::login) return right(route.token) ? Refusal::none : Refusal::token;
  if (!admitted(head)) return Refusal::token;
  if (route.part == Part::nothing) return Refusal::unknown;
  // A page of another site sends its Origin; a program that is no browser sends none.
  if ((route.part == Part::live) != head.upgrade) return Refusal::upgrade;
  return Refusal::none;
}

int status_of(Refusal refusal) noexcept {
  static constexpr std::array<int, 7> kStatus{200, 421, 403, 401, 405, 426, 404};
  return kStatus[static_cast<std::size_t>(refusal)];
}

std::string_view text_of(Refusal refusal) noexcept {
  static constexpr std::array<std::string_view, 7> kTexts{
      "",
      "This is not the page of that name. The setting \"hosts\" of slipd-web lists further names.",
      "Pages of other sites may not ask.",
      "A token is needed: open this address with ?token=TOKEN once. The file of slipd-web's setting "
      "token_file has it.",
      "This page is read-only: GET and HEAD only.",
      "/live is a WebSocket, and nothing else is.",
      "There is nothing by this name."};
  return kTexts[static_cast<std::size_t>(refusal)];
}

std::vector<std::string> host_names(const std::string& address, bool loopback, std::uint16_t port,
                                    const std::vector<std::string>& further) {
  constexpr std::uint16_t kHttp = 80;
  const std::string number = ":" + std::to_string(port);
  const bool six = address.find(':') != address.npos;
  std::vector<std::string> names{six ? "[" + address + "]" : address};
  if (loopback) names.emplace_back("localhost");
  std::vector<std::string> hosts = further;
  for (const std::string& name : names) {
    hosts.push_back(name + number);
    if (port == kHttp) hosts.push_back(name);
  }
  return hosts;
}

}  // namespace slipd::web
