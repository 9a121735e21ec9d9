// What slipd-web answers a request with, decided from its head alone: which part of the page it asks for, and
// whether it may. No sockets. Any thread.
//
// A page of another site that runs in the same browser can send requests to 127.0.0.1, and by DNS rebinding
// even read the answers. So the names in Host and Origin must be this page's own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slipd::web {

// The head of a request. Text that is absent is empty.
struct RequestHead {
  // "GET", …
  std::string_view method;
  // As in the request line.
  std::string_view target;
  // Field Host. Absent, or there twice: empty.
  std::string_view host;
  // Field Origin; absent: none.
  std::optional<std::string_view> origin;
  // Field Cookie.
  std::string_view cookie;
  // Field Authorization.
  std::string_view authorization;
  // Whether it asks to become a WebSocket.
  bool upgrade = false;
};

enum class Part : std::uint8_t {
  nothing,     // there is no such part
  page,        // a file of the page; name: its path, "index.html" for "/"
  live,        // the WebSocket
  recordings,  // the list, as JSON
  recording,   // one recording; name: its file name
  method,      // sensors and their tradeoffs, as JSON
  counts,      // what was served and refused, as JSON
  login        // "/?token=…": answered by a cookie
};

// Where a target leads. `name` has no '/' and no control character, and does not begin with '.'.
struct Route {
  Part part = Part::nothing;
  std::string name;
  // Of login: the token that was given.
  std::string token;
};
Route route_of(std::string_view target);

// Why a request is refused.
enum class Refusal : std::uint8_t { none, host, origin, token, method, upgrade, unknown };

// Names and token of this page.
class RequestRules {
 public:
  // `hosts`: what Host may be, with the port unless it is that of the scheme. `token`: empty: none is asked
  // for.
  RequestRules(std::vector<std::string> hosts, std::string token);
  // Whether a request to `route` may be answered.
  Refusal judge(const RequestHead& head, const Route& route) const;
  // Whether a token is the right one. Takes as long for any.
  bool right(std::string_view token) const noexcept;
  // Name and value of the cookie that admits a browser that asks for `host`. Cookies are shared by all ports
  // of a host, so the name has the port: several of these pages do not overwrite each other's.
  std::string cookie(std::string_view host) const;

 private:
  bool own_host(std::string_view host) const;
  bool own_origin(std::string_view origin) const;
  bool admitted(const RequestHead& head) const;

  std::vector<std::string> hosts_;
  std::string token_;
};

// The status code of HTTP for a refusal, and a sentence for people.
int status_of(Refusal refusal) noexcept;
std::string_view text_of(Refusal refusal) noexcept;

// What the server is called by: the address with its port, localhost if it is loopback, and `further`.
std::vector<std::string> host_names(const std::string& address, bool loopback, std::uint16_t port,
                                    const std::vector<std::string>& further);

}  // namespace slipd::web
