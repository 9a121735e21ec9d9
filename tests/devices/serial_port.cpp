// A serial line: the packets of a scan are its bytes.
#include <fcntl.h>
#include <unistd.h>

#include <array>

#include "tests/devices/port.hpp"
#include "tests/devices/pty_line.hpp"

namespace slipd::devices {
namespace {

class SerialPort final : public Port {
 public:
  SerialPort(const DeviceModel& model, const std::string& link) : Port(model), line_(link) {}

  void watch(std::vector<pollfd>& waits) const override { line_.watch(waits); }

  void serve() override {
    if (!line_.heard()) return;
    std::array<std::uint8_t, 512> bytes{};
    const ssize_t got = ::read(line_.device(), bytes.data(), bytes.size());
    if (got > 0 && model_.receive) model_.receive({0, {bytes.begin(), bytes.begin() + got}}, host_state_);
  }

  // What the host does not read is lost, as on a line.
  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) {
      const auto sent = ::write(line_.device(), packet.bytes.data(), packet.bytes.size());
      static_cast<void>(sent);
    }
  }

  void plug() override {
    if (plugged_) return;
    line_.plug();
    checked(::fcntl(line_.device(), F_SETFL, O_NONBLOCK), "pseudo-terminal");
    start();
  }

  void unplug() override {
    line_.unplug();
    plugged_ = false;
  }

  std::string place() const override { return line_.link(); }

 private:
  PtyLine line_;
};

}  // namespace

std::unique_ptr<Port> make_serial_port(const DeviceModel& model, const std::string& link) {
  return std::make_unique<SerialPort>(model, link);
}

}  // namespace slipd::devices
