// A Modbus slave by libmodbus' server side, over TCP on loopback or over a pseudo-terminal. The registers
// hold the last scan.
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <pty.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

#include "tests/devices/port.hpp"

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
  PtyPort(const DeviceModel& model, std::string link)
      : ModbusPort(model, modbus_new_rtu("pty", model.modbus->baud ? model.modbus->baud : 19200, 'N', 8, 1)),
        link_(std::move(link)) {}
  ~PtyPort() override { ::unlink(link_.c_str()); }

  void watch(std::vector<pollfd>& waits) const override {
    if (master_) waits.push_back({master_.get(), POLLIN, 0});
  }

  void serve() override {
    pollfd wait{master_.get(), POLLIN, 0};
    if (master_ && ::poll(&wait, 1, 0) == 1) answer(master_.get());
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

std::unique_ptr<Port> make_modbus_tcp_port(const DeviceModel& model, int tcp_port) {
  return std::make_unique<TcpPort>(model, tcp_port);
}

std::unique_ptr<Port> make_modbus_pty_port(const DeviceModel& model, const std::string& link) {
  return std::make_unique<PtyPort>(model, link);
}

}  // namespace slipd::devices
