// The input by which a controller sets the normal force of a simulated gripper: a Unix datagram socket, each
// datagram a normal force in N. A control loop can so be closed from any language, without the daemon.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace slipd::sim {

// Parses `2.5` or `{"normal_n": 2.5}`, N, with white space where JSON allows it. Nothing for any other text
// and for numbers that are negative or not finite.
std::optional<double> parse_grip(std::string_view datagram) noexcept;

class GripInput {
 public:
  // Creates the socket, and replaces one without a listener. Throws DriverError, which names the path.
  explicit GripInput(std::string path);
  ~GripInput();  // removes the socket
  GripInput(const GripInput&) = delete;
  GripInput& operator=(const GripInput&) = delete;

  // Acquire thread; neither waits nor allocates. The newest force since the last call. Malformed datagrams
  // are ignored.
  std::optional<double> newest() noexcept;

 private:
  std::string path_;
  int fd_;
};

}  // namespace slipd::sim
