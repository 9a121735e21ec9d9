// A gripper on Modbus, RTU or TCP, by its profile. libmodbus implements the protocol.
#include <modbus/modbus.h>

#include <cerrno>
#include <vector>

#include "grip/grippers/gripper_profile.hpp"

namespace slipd::grip {
namespace {

struct Frees {
  void operator()(modbus_t* context) const noexcept {
    modbus_close(context);
    modbus_free(context);
  }
};

class ModbusGripper final : public Gripper {
 public:
  ModbusGripper(const nlohmann::json& settings, double most_n)
      : profile_(load_profile(settings.at("profile"))),
        place_(settings.at("at").get<std::string>()),
        answer_us_(static_cast<std::uint32_t>(settings.at("answer_ms").get<double>() * 1000)),
        most_n_(most_n) {
    if (profile_.least_n() > most_n)
      throw GripperError("gripper at " + place_ + ": its least force is " +
                         std::to_string(profile_.least_n()) +
                         " N, above force.most_n; it cannot hold an object that bears no more");
    context_.reset(profile_.is_rtu() ? modbus_new_rtu(place_.c_str(), profile_.baud(), 'N', 8, 1) : tcp());
    if (!context_ || modbus_set_slave(context_.get(), profile_.unit()) != 0 ||
        modbus_set_response_timeout(context_.get(), answer_us_ / 1'000'000, answer_us_ % 1'000'000) != 0)
      throw GripperError("gripper at " + place_ + ": " + modbus_strerror(errno) +
                         "; \"at\" is a serial line such as /dev/ttyUSB0, or HOST:PORT");
  }

  void connect() override {
    modbus_close(context_.get());
    if (modbus_connect(context_.get()) != 0) fail("cannot be reached");
  }

  std::optional<GripperFacts> obey(const Command& command) override {
    GripperProfile::Status status = read();
    if (command.order.move == Move::stay) return status.facts;
    if (!status.ready) {
      if (command.order.move != Move::open || profile_.activation().empty()) fail_inactive();
      if (!activating_)
        for (const RegisterWrite& one : profile_.activation()) write(one);
      activating_ = true;
      return std::nullopt;
    }
    activating_ = false;
    if (status.busy) return std::nullopt;
    write(profile_.write(command, most_n_));
    return healthy(read()).facts;
  }

  GripperFacts look(const Command& last) override {
    const GripperProfile::Status status = healthy(read());
    if (last.order.move != Move::stay && !status.ready) fail_inactive();
    return status.facts;
  }

 private:
  modbus_t* tcp() const {
    const auto colon = place_.rfind(':');
    if (colon == std::string::npos) return nullptr;
    return modbus_new_tcp_pi(place_.substr(0, colon).c_str(), place_.substr(colon + 1).c_str());
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw GripperError("gripper at " + place_ + " " + what + ": " + modbus_strerror(errno));
  }

  const GripperProfile::Status& healthy(const GripperProfile::Status& status) const {
    if (status.fault)
      throw GripperFault("gripper at " + place_ + " tells of a fault: look at its display or lamp");
    return status;
  }

  [[noreturn]] void fail_inactive() const {
    throw GripperError("gripper at " + place_ +
                       " is not activated, which moves it: empty it, and order slipd-grip open");
  }

  GripperProfile::Status read() {
    std::vector<std::uint16_t> registers(static_cast<std::size_t>(profile_.read_count()));
    const auto function = profile_.reads_input() ? modbus_read_input_registers : modbus_read_registers;
    if (function(context_.get(), profile_.read_first(), profile_.read_count(), registers.data()) !=
        profile_.read_count())
      fail("does not answer");
    return profile_.status(registers);
  }

  void write(const RegisterWrite& one) {
    const int count = static_cast<int>(one.values.size());
    if (modbus_write_registers(context_.get(), one.first, count, one.values.data()) != count)
      fail("takes no order");
  }

  GripperProfile profile_;
  std::string place_;
  std::uint32_t answer_us_;
  double most_n_;
  bool activating_ = false;
  std::unique_ptr<modbus_t, Frees> context_;
};

}  // namespace

std::unique_ptr<Gripper> make_modbus_gripper(const nlohmann::json& settings, double most_n) {
  return std::make_unique<ModbusGripper>(settings, most_n);
}

}  // namespace slipd::grip
