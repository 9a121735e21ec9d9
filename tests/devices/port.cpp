#include "tests/devices/port.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <stdexcept>

namespace slipd::devices {

int checked(int result, const std::string& what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

Fd listen_on_loopback(int& port) {
  Fd listener(checked(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), "socket"));
  const int yes = 1;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  checked(::bind(listener.get(), generic, size), "TCP port " + std::to_string(port));
  checked(::listen(listener.get(), 16), "listen");
  checked(::getsockname(listener.get(), generic, &size), "getsockname");
  port = ntohs(address.sin_port);
  return listener;
}

std::unique_ptr<Port> make_port(const DeviceModel& model, const std::string& place,
                                const std::string& serial) {
  const std::size_t colon = place.find(':');
  const std::string kind = place.substr(0, colon);
  const std::string where = colon == std::string::npos ? "" : place.substr(colon + 1);
  if (kind == "can" || kind == "fd") {
    if (!model.usb && !model.hid && !model.modbus) {
      return kind == "can" ? make_can_port(model, where) : make_can_port(model, std::stoi(where));
    }
  } else if (kind == "usbip" && model.usb) {
    return make_usbip_port(model, std::stoi(where), serial);
  } else if (kind == "uhid" && model.hid) {
    return make_uhid_port(model, serial);
  } else if (kind == "tcp" && model.modbus) {
    return make_modbus_tcp_port(model, std::stoi(where));
  } else if ((kind == "tty" || kind == "adapter") && !model.hid && !model.modbus) {
    return kind == "tty" ? make_serial_port(model, where) : make_adapter_port(model, where);
  } else if (kind == "pty" && model.modbus) {
    return make_modbus_pty_port(model, where);
  }
  throw std::invalid_argument(
      std::string(model.name) + " cannot be plugged into '" + place +
      "': say can:, fd:, usbip:, uhid, tcp:, pty:, tty: or adapter:, as the device needs");
}

}  // namespace slipd::devices
