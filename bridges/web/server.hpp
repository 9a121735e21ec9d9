// The HTTP and WebSocket server: a thread of its own with Boost.Asio's loop. libslipd's requests wait for
// their answers, so they are in the main thread (Reader), and nothing that browsers do waits for slipd, nor
// slipd's answers for a browser.
//
// The functions below are called from the main thread. They hand text over to the serving thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "bridges/web/settings.hpp"

namespace slipd::web {

// What browsers need from slipd at this time.
struct Wanted {
  // Live pages that are open.
  int browsers = 0;
  // Sensors of which a browser is ready for a picture.
  std::set<std::string> looks;
  // Whether somebody waits for the answer to api/method.
  bool method = false;
  bool operator==(const Wanted&) const = default;
};

class Server {
 public:
  // Listens; the log names the address. `changed`: called in the serving thread when wanted() has changed; it
  // must not wait. Throws std::exception if the address cannot be listened on, or the token not be read.
  Server(const Settings& settings, std::function<void()> changed);
  // Ends all connections and the thread.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  Wanted wanted() const;
  // The newest estimates, for every live page. A page that is not ready gets the next ones only.
  void publish_live(std::string message);
  // The newest status, for every live page.
  void publish_status(std::string message);
  // A picture of a sensor, for those that look at it.
  void publish_picture(const std::string& sensor, std::string picture);
  // Where a sensor's taxels are, for those that look at it.
  void publish_layout(const std::string& sensor, std::string layout);
  // The answer to api/method.
  void publish_method(std::string json);
  // Whether the serving thread has run since the last call, or this is the first. Does not wait for it.
  bool answers();
  // TCP port that it listens on.
  std::uint16_t port() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace slipd::web
