// A pseudo-terminal in place of a serial line: the packets of a scan are its bytes.
#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>

#include "tests/devices/port.hpp"

namespace slipd::devices {
namespace {

class SerialPort final : public Port {
 public:
  SerialPort(const DeviceModel& model, std::string link) : Port(model), link_(std::move(link)) {}
  ~SerialPort() override { ::unlink(link_.c_str()); }

  void watch(std::vector<pollfd>& waits) const override {
    if (master_) waits.push_back({master_.get(), POLLIN, 0});
  }

  void serve() override {
    pollfd wait{master_.get(), POLLIN, 0};
    if (!master_ || ::poll(&wait, 1, 0) != 1) return;
    std::array<std::uint8_t, 512> bytes{};
    const ssize_t got = ::read(master_.get(), bytes.data(), bytes.size());
    if (got > 0 && model_.receive) model_.receive({0, {bytes.begin(), bytes.begin() + got}}, host_state_);
  }

  // What the host does not read is lost, as on a line.
  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) {
      const auto sent = ::write(master_.get(), packet.bytes.data(), packet.bytes.size());
      static_cast<void>(sent);
    }
  }

  // The host's end stays open here as well, so that a host may come and go.
  void plug() override {
    if (plugged_) return;
    int master = -1, host = -1;
    char name[64];
    termios raw{};
    ::cfmakeraw(&raw);
    checked(::openpty(&master, &host, name, &raw, nullptr), "pseudo-terminal");
    master_ = Fd(master);
    host_ = Fd(host);
    checked(::fcntl(master, F_SETFL, O_NONBLOCK), "pseudo-terminal");
    ::unlink(link_.c_str());
    checked(::symlink(name, link_.c_str()), "symbolic link " + link_);
    start();
  }

  void unplug() override {
    ::unlink(link_.c_str());
    master_ = Fd();
    host_ = Fd();
    plugged_ = false;
  }

  std::string place() const override { return link_; }

 private:
  std::string link_;
  Fd master_, host_;
};

}  // namespace

std::unique_ptr<Port> make_serial_port(const DeviceModel& model, const std::string& link) {
  return std::make_unique<SerialPort>(model, link);
}

}  // namespace slipd::devices
