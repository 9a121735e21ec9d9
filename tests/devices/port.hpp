// The bus connection of a simulated device. A port owns its file descriptors, never blocks for long and has
// no thread or clock: the caller waits on the descriptors of watch() and then calls serve().
#pragma once

#include <poll.h>

#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/storage/unique_fd.hpp"
#include "tests/devices/device_model.hpp"

namespace slipd::devices {

class Port {
 public:
  explicit Port(const DeviceModel& model) : model_(model) {}
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  virtual ~Port() = default;

  virtual void watch(std::vector<pollfd>& waits) const = 0;  // appends the descriptors to wait on
  virtual void serve() = 0;                                  // handles pending messages of the host
  virtual void send(std::span<const Packet> scan) = 0;
  virtual void plug() = 0;              // throws std::system_error
  virtual void unplug() = 0;            // as if the cable were pulled
  virtual void silence(bool /*on*/) {}  // a polled device does not answer; other devices stop sending anyway

  // Its address for a host: an interface, a port, a path.
  virtual std::string place() const = 0;

  // Whether the host has started the device since it was plugged in.
  bool streaming() const { return plugged_ && host_state_.streaming; }

 protected:
  const DeviceModel& model_;
  HostState host_state_;
  bool plugged_ = false;

  void start() {
    plugged_ = true;
    host_state_ = {.streaming = model_.starts_by_itself};
  }
};

using Fd = UniqueFd;

// The result of a system call. Throws std::system_error, which names `what`.
int checked(int result, const std::string& what);

// Listens on TCP of this machine. `port` 0 is replaced by a free port. Throws std::system_error.
Fd listen_on_loopback(int& port);

// `place` is one of
//   can:INTERFACE  a SocketCAN interface      fd:N       a socket that carries struct can_frame
//   usbip:PORT     a USB/IP server            uhid       /dev/uhid
//   tcp:PORT       a Modbus TCP slave         pty:PATH   a Modbus RTU slave at a symbolic link
//   tty:PATH       a serial line at a symbolic link
//   adapter:PATH   the serial line there, at 3 Mbit/s
// Port 0 means any that is free. Throws std::invalid_argument where the device does not fit,
// std::system_error otherwise.
std::unique_ptr<Port> make_port(const DeviceModel& model, const std::string& place,
                                const std::string& serial);

std::unique_ptr<Port> make_can_port(const DeviceModel& model, const std::string& interface);
std::unique_ptr<Port> make_can_port(const DeviceModel& model, int socket);  // takes ownership of the socket
std::unique_ptr<Port> make_usbip_port(const DeviceModel& model, int tcp_port, const std::string& serial);
std::unique_ptr<Port> make_uhid_port(const DeviceModel& model, const std::string& serial);
std::unique_ptr<Port> make_modbus_tcp_port(const DeviceModel& model, int tcp_port);
std::unique_ptr<Port> make_modbus_pty_port(const DeviceModel& model, const std::string& link);
std::unique_ptr<Port> make_serial_port(const DeviceModel& model, const std::string& link);
std::unique_ptr<Port> make_adapter_port(const DeviceModel& model, const std::string& path);

}  // namespace slipd::devices
