// A simulated gripper on Modbus: registers that a test sets and reads, served in a thread, on TCP of this
// machine or on a pseudo-terminal. It can be deaf and can be gone.
#pragma once

#include <modbus/modbus.h>
#include <sys/socket.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/devices/port.hpp"
#include "tests/devices/pty_line.hpp"

namespace slipd::devices {

class GripperOnModbus {
 public:
  // `link`: of a pseudo-terminal; empty: TCP.
  explicit GripperOnModbus(int unit, const std::string& link = {})
      : context_(link.empty() ? modbus_new_tcp("127.0.0.1", 1) : modbus_new_rtu("pty", 115200, 'N', 8, 1)),
        map_(modbus_mapping_new(0, 0, kRegisters, kRegisters)),
        line_(link) {
    modbus_set_slave(context_.get(), unit);
    if (link.empty())
      listener_ = listen_on_loopback(port_);
    else
      line_.plug();
    serve_ = std::thread([this, tcp = link.empty()] { run(tcp); });
  }
  ~GripperOnModbus() {
    ended_.store(true);
    serve_.join();
  }
  GripperOnModbus(const GripperOnModbus&) = delete;
  GripperOnModbus& operator=(const GripperOnModbus&) = delete;

  std::string place() const {
    return line_.link().empty() ? "127.0.0.1:" + std::to_string(port_) : line_.link();
  }
  void set_input(int at, std::uint16_t value) {
    locked([&] { map_->tab_input_registers[at] = value; });
  }
  void set_holding(int at, std::uint16_t value) {
    locked([&] { map_->tab_registers[at] = value; });
  }
  std::uint16_t holding(int at) {
    std::uint16_t value = 0;
    locked([&] { value = map_->tab_registers[at]; });
    return value;
  }
  int writes() const { return writes_.load(); }
  void be_silent(bool silent) { silent_.store(silent); }

 private:
  static constexpr int kRegisters = 2100;
  struct Closes {
    void operator()(modbus_t* it) const { modbus_free(it); }
    void operator()(modbus_mapping_t* it) const { modbus_mapping_free(it); }
  };

  template <class F>
  void locked(F&& f) {
    const std::lock_guard lock(mutex_);
    f();
  }

  void run(bool tcp) {
    while (!ended_.load()) {
      pollfd waits[] = {{tcp ? listener_.get() : line_.device(), POLLIN, 0}, {peer_.get(), POLLIN, 0}};
      constexpr int kLookAgainMs = 20;  // for the end
      if (::poll(waits, 2, kLookAgainMs) <= 0) continue;
      if (!tcp) answer(line_.device());
      if (tcp && waits[0].revents != 0)
        peer_ = Fd(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      else if (tcp && waits[1].revents != 0 && !answer(peer_.get()))
        peer_ = Fd();
    }
  }

  bool answer(int fd) {
    std::uint8_t request[MODBUS_TCP_MAX_ADU_LENGTH];
    modbus_set_socket(context_.get(), fd);
    const int length = modbus_receive(context_.get(), request);
    if (length <= 0 || silent_.load()) return length >= 0;
    const int function = request[modbus_get_header_length(context_.get())];
    locked([&] { modbus_reply(context_.get(), request, length, map_.get()); });
    if (function == MODBUS_FC_WRITE_MULTIPLE_REGISTERS) writes_.fetch_add(1);
    return true;
  }

  std::unique_ptr<modbus_t, Closes> context_;
  std::unique_ptr<modbus_mapping_t, Closes> map_;
  PtyLine line_;
  Fd listener_, peer_;
  int port_ = 0;
  std::mutex mutex_;  // of the registers
  std::atomic<int> writes_{0};
  std::atomic<bool> silent_{false}, ended_{false};
  std::thread serve_;
};

}  // namespace slipd::devices
