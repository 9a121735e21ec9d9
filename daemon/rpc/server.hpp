// The socket server: takes clients in, hands their lines to the methods, tells subscribers what the pipeline
// has found. All of it in the io thread.
#pragma once

#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <asio/steady_timer.hpp>
#include <memory>
#include <set>
#include <vector>

#include "daemon/record/recorder.hpp"
#include "daemon/rpc/client.hpp"
#include "daemon/rpc/rpc_methods.hpp"
#include "daemon/telemetry/frame_health_monitor.hpp"
#include "daemon/telemetry/metrics_file.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Who is connected. Outlives a server, so that the next one, with another configuration, goes on with them.
struct Clients {
  Client::Owner owner;  // the server's of now
  std::set<std::shared_ptr<Client>> all;
  std::uint64_t dropped_for_gone = 0;
  void close_all();  // what they have not read is lost
};

class Server {
 public:
  // Serves those who are connected and those who come to `listener`, its own from now on.
  Server(asio::io_context& io, ServiceContext& context, Clients& clients, Recorder& recorder, int listener);
  ~Server();  // no more news, no new clients; who waits for a frame is told that it will not come
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

 private:
  struct Last {
    State state = State::stale;
    Alert alert = Alert::none;
  };
  template <typename Body>
  auto while_alive(Body body);
  void accept_when_ready();
  bool accept_one();
  void turn_away(const UniqueFd& socket);
  void listen_for_news();
  void take_news();
  void tell(const Event& event);
  void tell(const Event& event, EventKind kind);
  void follow_grasps();
  void measure_rates();
  void look_at_sensors();

  asio::io_context& io_;
  ServiceContext& context_;
  Clients& clients_;
  RpcMethods methods_;
  asio::posix::stream_descriptor listener_, news_;
  asio::steady_timer pause_;  // before accepting again, when there is no descriptor left
  asio::steady_timer rates_;
  FrameHealthMonitor health_monitor_;
  MetricsFile metrics_file_;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);  // gone with this, for handlers
  std::vector<Last> last_;                                                  // per sensor, as told
  std::vector<Alert> grasp_alerts_;                                         // per grasp, as last seen
  std::vector<std::uint64_t> last_estimated_;
  std::chrono::steady_clock::time_point last_measured_;
};

}  // namespace slipd
