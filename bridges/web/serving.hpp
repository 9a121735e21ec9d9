// What the server's sessions share. Private to the server. Serving thread only, except where said.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "bridges/web/counts.hpp"
#include "bridges/web/request_rules.hpp"
#include "bridges/web/server.hpp"
#include "bridges/web/settings.hpp"

namespace slipd::web {

// A message that several sessions send.
using Message = std::shared_ptr<const std::string>;

class LiveSession;
class HttpSession;

// Limits on what one connection may do.
struct Limits {
  // Longest head of a request, bytes. A browser's are below 2000.
  std::uint32_t head_bytes = 8192;
  // A head must be complete, and a connection that was kept must ask again, within this, s. Shorter: slow
  // radio links fail; longer: a slow loris holds a connection.
  int head_s = 5;
  // Without progress of an answer for this long, the connection ends, s.
  int answer_s = 20;
  // Requests on one connection, after which it ends.
  int requests = 1000;
  // A live page must say within this that it took a message, s.
  int ready_s = 20;
  // Longest message of a browser, bytes.
  std::size_t message_bytes = 256;
  // Messages of a browser a second, on average and at once. A page at 60 Hz sends 120.
  double messages_hz = 250;
  double messages_at_once = 500;
  // What the kernel may keep for a browser, bytes: what is there is old when it is read.
  int send_buffer_bytes = 128 * 1024;
  // Connections for files, for each live page that is allowed.
  int connections_per_browser = 4;
};

struct Serving {
  Serving(const Settings& given, std::function<void()> on_change)
      : settings(given), changed(std::move(on_change)) {}

  Settings settings;
  Limits limits;
  std::function<void()> changed;
  std::unique_ptr<RequestRules> rules;
  Counts counts;
  int connections = 0;
  std::set<LiveSession*> live;
  Message hello;
  std::map<std::string, Message, std::less<>> layouts;
  // Called with the answer to api/method.
  std::vector<std::function<void(Message)>> waiting_for_method;

  // Any thread.
  std::mutex mutex;
  Wanted wanted;

  // Last, so that it is destroyed first: it owns the sessions, which use all of the above.
  boost::asio::io_context io{1};

  // Finds out what is wanted, and says so if it is something else.
  void update_wanted();
};

// Takes a connection over and serves it to its end.
void serve_http(Serving& serving, boost::asio::ip::tcp::socket socket);

}  // namespace slipd::web
