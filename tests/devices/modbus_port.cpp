// A Modbus slave by libmodbus' server side, over TCP on loopback or over a pseudo-terminal. The registers
// hold the last scan.
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

#include "tests/devices/port.hpp"
#include "tests/devices/pty_line.hpp"

namespace slipd::devices {
namespace {

struct Closes {
  void operator()(modbus_t* it) const { modbus_free(it); }
  void operator()(modbus_mapping_t* it) const { modbus_mapping_free(it); }
};

class ModbusPort : public Port {
 public:
  ModbusPort(const DeviceModel& model, modbus_t* context) : Port(model), context_(context) {
    if (!context_) throw std::system_error(errno, std::generic_category(), "libmodbus");
    modbus_set_slave(context_.get(), model.modbus->unit);
    set_registers(model.modbus->registers);
  }

  // After a scan of another length the register map has that length; a request for more gets an exception.
  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) {
      const int count = static_cast<int>(packet.bytes.size() / 2);
      if (count != map_->nb_registers) set_registers(count);
      for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(2 * i);
        map_->tab_registers[i] = static_cast<std::uint16_t>(packet.bytes[at] << 8 | packet.bytes[at + 1]);
      }
    }
  }

  void silence(bool on) override { silent_ = on; }

 protected:
  // One request from `fd`. False: the other side is gone.
  bool answer(int fd) {
    std::uint8_t request[MODBUS_TCP_MAX_ADU_LENGTH];
    modbus_set_socket(context_.get(), fd);
    const int length = modbus_receive(context_.get(), request);
    if (length > 0 && !silent_) modbus_reply(context_.get(), request, length, map_.get());
    return length >= 0;
  }

 private:
  void set_registers(int count) {
    const auto first = static_cast<unsigned>(model_.modbus->first_register),
               size = static_cast<unsigned>(count);
    map_.reset(modbus_mapping_new_start_address(0, 0, 0, 0, first, size, first, size));
  }

  std::unique_ptr<modbus_t, Closes> context_;
  std::unique_ptr<modbus_mapping_t, Closes> map_;
  bool silent_ = false;
};

class TcpPort final : public ModbusPort {
 public:
  TcpPort(const DeviceModel& model, int port)
      : ModbusPort(model, modbus_new_tcp("127.0.0.1", port)), port_(port) {}

  void watch(std::vector<pollfd>& waits) const override {
    if (listener_) waits.push_back({listener_.get(), POLLIN, 0});
    if (client_) waits.push_back({client_.get(), POLLIN, 0});
  }

  void serve() override {
    if (readable(listener_)) client_ = Fd(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (readable(client_) && !answer(client_.get())) client_ = Fd();
  }

  void plug() override {
    if (plugged_) return;
    listener_ = listen_on_loopback(port_);
    start();
  }

  void unplug() override {
    listener_ = Fd();
    client_ = Fd();
    plugged_ = false;
  }

  std::string place() const override { return std::to_string(port_); }

 private:
  static bool readable(const Fd& fd) {
    pollfd wait{fd.get(), POLLIN, 0};
    return fd && ::poll(&wait, 1, 0) == 1;
  }

  int port_;
  Fd listener_, client_;
};

class PtyPort final : public ModbusPort {
 public:
  PtyPort(const DeviceModel& model, const std::string& link)
      : ModbusPort(model, modbus_new_rtu("pty", model.modbus->baud ? model.modbus->baud : 19200, 'N', 8, 1)),
        line_(link) {}

  void watch(std::vector<pollfd>& waits) const override { line_.watch(waits); }

  void serve() override {
    if (line_.heard()) answer(line_.device());
  }

  void plug() override {
    if (plugged_) return;
    line_.plug();
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

std::unique_ptr<Port> make_modbus_tcp_port(const DeviceModel& model, int tcp_port) {
  return std::make_unique<TcpPort>(model, tcp_port);
}

std::unique_ptr<Port> make_modbus_pty_port(const DeviceModel& model, const std::string& link) {
  return std::make_unique<PtyPort>(model, link);
}

}  // namespace slipd::devices
