// A Modbus TCP server of slipd's board in shared memory. Registers are made when a client asks, so that the
// board costs nothing between requests. One thread's own: that of the loop, which never waits for slipd.
//
// Requests are taken apart here as far as their length and function, because libmodbus waits for the rest of
// a request. Only "read input registers" reaches libmodbus; every other function is answered with
// exception 1.
#pragma once

#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bridges/modbus/live_registers.hpp"
#include "bridges/support/program.hpp"

using modbus_t = struct _modbus;  // modbus.h has only the second name
using modbus_mapping_t = struct _modbus_mapping_t;

namespace slipd::modbus {

struct ServerSettings {
  // IPv4 address and TCP port to listen on.
  std::string address = "127.0.0.1";
  int port = 502;
  // Names of the blocks; empty: sensors, then grasps.
  std::vector<std::string> blocks;
  // Older estimates are stale, s.
  double max_age_s = 0.1;
  // Further connections are closed.
  std::size_t max_clients = 16;
  // A connection without a request for this long is closed.
  std::chrono::milliseconds idle{60'000};
  // slipd's socket.
  std::string socket = SLIPD_SOCKET;
};

// From settings that fit modbus.schema.json.
ServerSettings server_settings_of(const nlohmann::json& checked);

class Server : public bridges::Service {
 public:
  // Listens. Throws std::runtime_error if the address cannot be had.
  Server(ServerSettings settings, bridges::Loop& loop);
  ~Server() override;

 private:
  struct Client;
  void listen_at();
  void accept_client();
  bool serve(Client& client);
  bool answer(Client& client, std::size_t length);
  void drop(Client* client);
  void look_around();

  struct Free {
    void operator()(modbus_t* context) const noexcept;
    void operator()(modbus_mapping_t* mapping) const noexcept;
  };
  ServerSettings settings_;
  bridges::Loop& loop_;
  std::unique_ptr<modbus_t, Free> context_;
  std::unique_ptr<modbus_mapping_t, Free> mapping_;
  int listening_ = -1;
  bridges::Loop::Watch listen_watch_;
  std::list<Client> clients_;
  bridges::Loop::Timer timer_;
  LiveRegisters registers_;
};

}  // namespace slipd::modbus
