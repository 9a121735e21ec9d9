// The socket server: accepts clients, passes their lines to the methods, sends notifications, and updates the
// statistics once a second.
#pragma once

#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <asio/steady_timer.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "daemon/record/recorder.hpp"
#include "daemon/rpc/clients/client.hpp"
#include "daemon/rpc/methods/rpc_methods.hpp"
#include "daemon/telemetry/frame_health_monitor.hpp"
#include "daemon/telemetry/metrics_file.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// The connected clients. They outlive a server, so that clients stay connected over a reload. Used by one
// thread: io.
struct Clients {
  // What subscribers were last told of a sensor; first what a board says before anything is published.
  struct Told {
    State state = State::stale;
    Alert alert = Alert::unknown;
    AlertCause alert_cause = AlertCause::none;
    // Whether no change has to be told.
    bool holds(const Estimate& now) const noexcept { return now.state == state && now.alert == alert; }
  };
  explicit Clients(asio::io_context& io) : owner(io) {}
  // Callbacks of the present server.
  Client::Owner owner;
  // All that are connected.
  std::set<std::shared_ptr<Client>> all;
  // Notifications dropped by clients that are closed.
  std::uint64_t dropped_by_closed = 0;
  // By sensor name, and kept for sensors that a reload removed: after a reload subscribers get an event for
  // each state and alert that differs from this.
  std::map<std::string, Told> told;
  // Closes all. Lines that wait are lost.
  void close_all();
  // Forgets those that are closed, unless their sockets cannot be let go yet: these keep their places.
  void forget_closed();
};

// Not thread-safe. Called from one thread: io.
class Server {
 public:
  // Serves the connected clients and accepts others on `listener`, which it owns. All references outlive it.
  Server(asio::io_context& io, ServiceContext& context, Clients& clients, Recorder& recorder, int listener);
  // Responds to pending requests with an error. Clients stay connected.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

 private:
  template <typename Body>
  auto while_alive(Body body);
  void accept_when_ready();
  bool accept_one();
  void wait_for_events();
  void drain_events();
  void take_events();
  void handle(const std::shared_ptr<Client>& client, std::string_view line);
  void judge_wakes();
  void complete_frames();
  void dispatch(const Event& event);
  void notify_of_event(const Event& event, Clients::Told& told);
  void tell_what_reload_changed();
  template <typename Accepts>
  void notify_subscribers(const Estimate& estimate, const std::string& sensor, bool simulated,
                          Clients::Told& told, Accepts accepts);
  template <typename Accepts>
  void send_event(const Estimate& estimate, const std::string& sensor, bool simulated, EventKind kind,
                  Accepts accepts);
  void trigger_on_grasp_slip();
  void schedule_statistics();
  void update_statistics();

  ServiceContext& context_;
  Clients& clients_;
  RpcMethods methods_;
  asio::posix::stream_descriptor listener_, events_ready_;
  asio::steady_timer accept_pause_;  // before accepting again when there was no descriptor or memory
  asio::steady_timer frames_pause_;  // before answering with frames again
  bool frames_pause_pending_ = false;
  asio::steady_timer statistics_timer_;
  FrameHealthMonitor health_monitor_;
  MetricsFile metrics_file_;
  std::shared_ptr<const bool> alive_ =
      std::make_shared<const bool>(true);  // expires with the server; handlers test it
  std::vector<Clients::Told*> told_;       // per sensor, in clients_.told
  std::vector<Alert> grasp_alerts_;        // per grasp, as last evaluated
  std::vector<std::uint64_t> last_estimated_, last_repeated_;
  std::chrono::steady_clock::time_point last_measured_;
};

}  // namespace slipd
