// Any frames on a CAN bus with two boards of taxels: the driver gives frames of finite numbers, and each
// read returns. Input: packets of an identifier (2 bytes), flags (extended, error, remote, FD), a length and
// the data.
#include <sys/socket.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "drivers/can/can_driver.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using fuzz::demand;
using Bytes = std::span<const std::uint8_t>;

SensorSetup board(int number) {
  SensorSetup setup = test::setup_of(TaxelLayout::grid(4, 4, 0.001), {{"board", number}});
  setup.name += std::to_string(number);
  setup.profile = "xela-xr1944";
  setup.device = {{"interface", "can0"}};
  return setup;
}

class Bus {
 public:
  Bus()
      : driver_({board(1), board(2)}, [this](const std::string&, const std::vector<std::uint32_t>&) {
          int ends[2];
          demand(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
          other_ = can::Socket(ends[1]);
          fd_ = ends[1];
          return can::Socket(ends[0]);
        }) {}

  void hear(Bytes in) {
    driver_.open();  // forgets all earlier packets
    while (in.size() > 4) {
      canfd_frame frame{};
      const bool fd = (in[2] & 8U) != 0;
      frame.can_id = in[0] | static_cast<canid_t>(in[1]) << 8U;
      if ((in[2] & 1U) != 0) frame.can_id |= CAN_EFF_FLAG;
      if ((in[2] & 2U) != 0) frame.can_id |= CAN_ERR_FLAG;
      if ((in[2] & 4U) != 0) frame.can_id |= CAN_RTR_FLAG;
      frame.len = in[3];  // any length, true or not
      const std::size_t size = std::min<std::size_t>({in[3], in.size() - 4, sizeof frame.data});
      std::memcpy(frame.data, in.data() + 4, size);
      in = in.subspan(4 + size);
      if (send(fd_, &frame, fd ? CANFD_MTU : CAN_MTU, MSG_DONTWAIT) > 0) read();
    }
  }

 private:
  void read() {
    std::array slots{first_.slot, second_.slot};
    const ReadResult result = driver_.read(slots, std::chrono::microseconds(0));
    demand(result.status != ReadStatus::disconnected && result.status != ReadStatus::end);
    demand(result.sensor < slots.size());
    if (result.status != ReadStatus::frame) return;
    for (const auto* own : {&first_, &second_}) {
      for (const float value : own->memory) demand(std::isfinite(value));
    }
  }

  test::OwnedSlot first_{16}, second_{16};
  can::Socket other_;
  int fd_ = -1;
  can::CanDriver driver_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Bus bus;
  bus.hear(Bytes(data, size));
  return 0;
}
