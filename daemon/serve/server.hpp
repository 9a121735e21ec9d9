// The socket server: takes clients in, hands their lines to the methods, tells subscribers what the pipeline
// has found. All of it in the io thread.
#pragma once

#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <asio/steady_timer.hpp>
#include <memory>
#include <set>
#include <vector>

#include "daemon/serve/client.hpp"
#include "daemon/serve/methods.hpp"
#include "daemon/serve/socket_file.hpp"
#include "daemon/serve/world.hpp"

namespace slipd {

class Server {
 public:
  // Listens from now on. Throws std::runtime_error as SocketFile does.
  Server(asio::io_context& io, World& world);
  ~Server();

  // No more news, no more clients. What clients have not read is lost.
  void stop();

 private:
  struct Last {
    State state = State::stale;
    Alert alert = Alert::none;
  };
  void accept_when_ready();
  void accept_one();
  void turn_away(const UniqueFd& socket);
  void listen_for_news();
  void tell(const Event& event);
  void tell(const Event& event, EventKind kind);
  void measure_rates();

  asio::io_context& io_;
  World& world_;
  Recorder recorder_;
  Methods methods_;
  SocketFile file_;
  asio::posix::stream_descriptor listener_, news_;
  asio::steady_timer pause_;  // before accepting again, when there is no descriptor left
  asio::steady_timer rates_;
  Client::Owner owner_;
  std::set<std::shared_ptr<Client>> clients_;
  std::uint64_t dropped_for_gone_ = 0;
  std::vector<Last> last_;  // per sensor, as told
  std::vector<std::uint64_t> last_estimated_;
  std::chrono::steady_clock::time_point last_measured_;
};

}  // namespace slipd
