// Nodes of this computer only, whichever of its addresses they give. A ROS 2 node on Fast DDS says the
// addresses of all interfaces but loopback, also if it looks for others on 127.0.0.1 only, and Cyclone DDS
// sends to an address only if it uses an interface of that network. So the node uses loopback and the other
// interfaces, and the kernel drops what comes from outside: the sockets that receive are bound to loopback,
// which all packets from this computer to itself come by. Multicast is sent with a time to live of 0, which
// stays on this computer.
#pragma once

#include <string>
#include <vector>

namespace slipd::ros2 {

// In `interfaces` of the settings: this computer.
inline constexpr const char* kHost = "host";

// An interface that is up, and its address.
struct HostInterface {
  std::string name;
  // IPv4.
  std::string address;
  bool operator==(const HostInterface&) const = default;
};

// Loopback first, then at most three others, in the kernel's order. Throws std::system_error.
std::vector<HostInterface> host_interfaces();

// Binds the sockets of this process that receive for the domain, 0 to 101, to loopback. False: the kernel
// refuses, as before Linux 5.7, or there are none. Throws std::filesystem::filesystem_error.
bool receive_from_host_only(unsigned domain);

// Readable when an IPv4 address of this computer has come or gone. One thread's own.
class AddressChanges {
 public:
  // Throws std::system_error.
  AddressChanges();
  ~AddressChanges();
  AddressChanges(const AddressChanges&) = delete;
  AddressChanges& operator=(const AddressChanges&) = delete;

  int fd() const noexcept { return fd_; }
  // Takes what has come, so that it is no longer readable.
  void take() const noexcept;

 private:
  int fd_;
};

}  // namespace slipd::ros2
