// Asks slipd for what browsers need, and only while there are browsers: estimates as they come, at most as
// often as the settings say, pictures of the sensors that are looked at, the status once a second. In the
// main thread, by libslipd.
//
// A subscription wakes it when there is something new; the estimates themselves come from `gamma`, which has
// the grasps and all fields. The page hears something at least every kHeartbeat, so that it can tell silence
// from a sensor at rest.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <slipd.hpp>
#include <string>

#include "bridges/support/bell.hpp"
#include "bridges/support/loop.hpp"
#include "bridges/support/program.hpp"
#include "bridges/web/answers/answer.hpp"
#include "bridges/web/server.hpp"
#include "bridges/web/settings.hpp"

namespace slipd::web {

// Longest time between two messages to a page. The page counts 800 ms of silence as lost.
inline constexpr std::chrono::milliseconds kHeartbeat{250};

class Reader : public bridges::Service {
 public:
  // Starts the server too. Throws as Server does.
  Reader(bridges::Loop& loop, Settings settings);
  ~Reader() override;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  const Server& server() const noexcept { return *server_; }

 private:
  using Clock = std::chrono::steady_clock;

  // How long it is until one period after `last`; at least 0.
  Clock::duration until_next(Clock::time_point last) const;
  void wanted_changed();
  void begin();
  void subscribe();
  void end();
  void take_events();
  void send_live();
  void send_status();
  void plan_pictures();
  void send_pictures();
  bool send_picture(const std::string& sensor);
  void check_server();
  void send_method();
  // Throws std::runtime_error with libslipd's text.
  Answer ask(const char* method, const std::string& params = "{}");
  std::string tradeoff_of(const std::string& sensor);

  bridges::Loop& loop_;
  Settings settings_;
  Clock::duration period_;                    // between two estimates, and two pictures of a sensor
  client::Connection requests_;               // what has an answer
  std::optional<client::Connection> events_;  // the subscription, while there are browsers
  std::unique_ptr<bridges::Bell> bell_;
  bridges::Loop::Timer estimates_, beat_, status_, pictures_, pulse_;
  bridges::Loop::Watch event_, rung_;
  Clock::time_point sent_{}, pictured_{};  // of the estimates; when the pictures were due
  Wanted wanted_;
  bool subscribed_ = false;
  std::string away_;                                   // why slipd is not reached; empty: it is
  std::string live_;                                   // the last live_message
  std::map<std::string, Clock::time_point> laid_out_;  // when a sensor's layout was asked for
  std::map<std::string, Clock::time_point> without_;   // sensors without a picture, and until when
  std::unique_ptr<Server> server_;                     // its thread uses bell_
};

}  // namespace slipd::web
