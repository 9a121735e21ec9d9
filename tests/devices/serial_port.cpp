// A serial line, a pseudo-terminal or one that is there: the packets of a scan are its bytes.
#include <fcntl.h>
#include <termios.h>
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

// The other end of a line that is there, say of an adapter, at 3 Mbit/s. It waits for the line, which loses
// nothing.
class AdapterPort final : public Port {
 public:
  AdapterPort(const DeviceModel& model, std::string path) : Port(model), path_(std::move(path)) {}

  void watch(std::vector<pollfd>&) const override {}
  void serve() override {}

  void send(std::span<const Packet> scan) override {
    constexpr int kPatienceMs = 10'000;
    for (const Packet& packet : scan) {
      for (std::span<const std::uint8_t> left = packet.bytes; !left.empty();) {
        const ssize_t sent = ::write(line_.get(), left.data(), left.size());
        if (sent > 0) {
          left = left.subspan(static_cast<std::size_t>(sent));
          continue;
        }
        pollfd wait{line_.get(), POLLOUT, 0};
        if (::poll(&wait, 1, kPatienceMs) != 1)
          throw std::system_error(ETIMEDOUT, std::generic_category(), path_);
      }
    }
  }

  void plug() override {
    if (plugged_) return;
    line_ = Fd(checked(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC), path_));
    termios raw{};
    ::cfmakeraw(&raw);
    raw.c_cflag |= CLOCAL | CREAD;
    ::cfsetspeed(&raw, B3000000);
    checked(::tcsetattr(line_.get(), TCSANOW, &raw), path_);
    start();
  }

  void unplug() override {
    if (line_) ::tcdrain(line_.get());
    line_ = Fd();
    plugged_ = false;
  }

  std::string place() const override { return path_; }

 private:
  std::string path_;
  Fd line_;
};

}  // namespace

std::unique_ptr<Port> make_adapter_port(const DeviceModel& model, const std::string& path) {
  return std::make_unique<AdapterPort>(model, path);
}

std::unique_ptr<Port> make_serial_port(const DeviceModel& model, const std::string& link) {
  return std::make_unique<SerialPort>(model, link);
}

}  // namespace slipd::devices
