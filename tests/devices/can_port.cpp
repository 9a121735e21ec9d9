// A device on a CAN bus: a SocketCAN interface, or on the host one end of a SOCK_SEQPACKET pair that carries
// can_frames.
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>

#include <cstring>

#include "tests/devices/port.hpp"

namespace slipd::devices {
namespace {

Fd open_interface(const std::string& name) {
  Fd fd(checked(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW), "CAN socket"));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(name.c_str()));
  checked(address.can_ifindex == 0 ? -1 : 0, "CAN interface " + name);
  checked(::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), "bind to " + name);
  return fd;
}

class CanPort final : public Port {
 public:
  CanPort(const DeviceModel& model, Fd socket, std::string place)
      : Port(model), socket_(std::move(socket)), place_(std::move(place)) {}

  void watch(std::vector<pollfd>& waits) const override { waits.push_back({socket_.get(), POLLIN, 0}); }

  void serve() override {
    can_frame frame{};
    while (::recv(socket_.get(), &frame, sizeof frame, MSG_DONTWAIT) == static_cast<ssize_t>(sizeof frame)) {
      const Packet said{frame.can_id & CAN_EFF_MASK,
                        Bytes(frame.data, frame.data + std::min<int>(frame.len, CAN_MAX_DLEN))};
      if (plugged_ && model_.receive) model_.receive(said, host_state_);
    }
  }

  // A full transmit queue loses frames, as on the bus.
  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) {
      can_frame frame{};
      frame.can_id = packet.address | (packet.address > CAN_SFF_MASK ? CAN_EFF_FLAG : 0U);
      frame.len = static_cast<std::uint8_t>(std::min<std::size_t>(packet.bytes.size(), CAN_MAX_DLEN));
      std::copy_n(packet.bytes.begin(), frame.len, frame.data);
      (void)::send(socket_.get(), &frame, sizeof frame, MSG_DONTWAIT | MSG_NOSIGNAL);
    }
  }

  void plug() override { start(); }
  void unplug() override { plugged_ = false; }
  std::string place() const override { return place_; }

 private:
  Fd socket_;
  std::string place_;
};

}  // namespace

std::unique_ptr<Port> make_can_port(const DeviceModel& model, const std::string& interface) {
  return std::make_unique<CanPort>(model, open_interface(interface), interface);
}

std::unique_ptr<Port> make_can_port(const DeviceModel& model, int socket) {
  return std::make_unique<CanPort>(model, Fd(socket), "descriptor " + std::to_string(socket));
}

}  // namespace slipd::devices
