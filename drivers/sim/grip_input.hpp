// The controller's hand on a simulated gripper: a Unix datagram socket, each datagram a normal force in N, so
// that a loop may be closed from any language without the daemon taking part.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace slipd::sim {

// `2.5` or `{"normal_n": 2.5}`, blanks where JSON allows them. Nothing for anything else and for numbers that
// are no force (negative, not finite).
std::optional<double> parse_grip(std::string_view datagram) noexcept;

class GripInput {
 public:
  // Makes the socket, in place of one that nobody listens on any more. Throws DriverError naming the path.
  explicit GripInput(std::string path);
  ~GripInput();  // and removes it
  GripInput(const GripInput&) = delete;
  GripInput& operator=(const GripInput&) = delete;

  // Acquire thread, never waits or allocates. The newest force that has come since the last call. Datagrams
  // that make no sense are passed over.
  std::optional<double> newest() noexcept;

 private:
  std::string path_;
  int fd_;
};

}  // namespace slipd::sim
