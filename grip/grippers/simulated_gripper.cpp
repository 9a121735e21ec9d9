// The fingers of slipd's driver sim: each sensor's grip_input takes the normal force as a datagram of text.
// And a gripper of nothing, which says in the journal what it would do.
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <vector>

#include "bridges/support/log.hpp"
#include "bridges/support/unix_address.hpp"
#include "grip/grippers/gripper.hpp"

namespace slipd::grip {
namespace {

class SimulatedGripper final : public Gripper {
 public:
  explicit SimulatedGripper(const nlohmann::json& settings)
      : inputs_(settings.at("grip_inputs").get<std::vector<std::string>>()),
        fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    if (fd_ < 0) throw GripperError("socket: " + std::generic_category().message(errno));
  }
  ~SimulatedGripper() override { ::close(fd_); }
  SimulatedGripper(const SimulatedGripper&) = delete;
  SimulatedGripper& operator=(const SimulatedGripper&) = delete;

  void connect() override {}

  std::optional<GripperFacts> obey(const Command& command) override {
    if (command.order.move == Move::stay) return GripperFacts{};
    char force[32];
    const int size = std::snprintf(force, sizeof force, "%.4f", command.order.force_n);
    for (const std::string& input : inputs_) send(input, {force, static_cast<std::size_t>(size)});
    return GripperFacts{};
  }

 private:
  void send(const std::string& input, std::string_view text) const {
    const auto address = bridges::unix_address(input);
    if (!address) throw GripperError("the path " + input + " is too long for a socket");
    if (::sendto(fd_, text.data(), text.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&*address),
                 sizeof *address) < 0)
      throw GripperError("the simulated finger at " + input +
                         " takes no force: " + std::generic_category().message(errno) +
                         "; slipd's sensor needs this path as its option grip_input");
  }

  std::vector<std::string> inputs_;
  int fd_;
};

class DryGripper final : public Gripper {
 public:
  void connect() override {}
  std::optional<GripperFacts> obey(const Command& command) override {
    char text[64];
    if (command.order.move == Move::grip)
      std::snprintf(text, sizeof text, "would grip with %.2f N", command.order.force_n);
    else
      std::snprintf(text, sizeof text, "would %s", command.order.move == Move::open ? "open" : "do nothing");
    bridges::log(bridges::LogLevel::info, text);
    return GripperFacts{};
  }
};

}  // namespace

std::unique_ptr<Gripper> make_simulated_gripper(const nlohmann::json& settings) {
  return std::make_unique<SimulatedGripper>(settings);
}

std::unique_ptr<Gripper> make_dry_gripper() {
  return std::make_unique<DryGripper>();
}

}  // namespace slipd::grip
