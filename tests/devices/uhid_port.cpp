// A HID device made through /dev/uhid: the kernel gives it a hidraw node as for a USB device.
#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "tests/devices/port.hpp"

namespace slipd::devices {
namespace {

template <std::size_t N>
void set_text(std::uint8_t (&field)[N], std::string_view text) {
  std::copy_n(text.begin(), std::min(text.size(), N - 1), field);
}

class UhidPort final : public Port {
 public:
  UhidPort(const DeviceModel& model, std::string serial)
      : Port(model),
        serial_(std::move(serial)),
        fd_(checked(::open("/dev/uhid", O_RDWR | O_NONBLOCK | O_CLOEXEC), "/dev/uhid")) {}

  void watch(std::vector<pollfd>& waits) const override { waits.push_back({fd_.get(), POLLIN, 0}); }

  void serve() override {
    uhid_event event{};
    if (::read(fd_.get(), &event, sizeof event) < 0) return;
    if (event.type == UHID_OUTPUT && model_.receive) {
      const std::uint8_t* data = event.u.output.data;
      model_.receive({0, Bytes(data, data + std::min<std::size_t>(event.u.output.size, UHID_DATA_MAX))},
                     host_state_);
    } else if (event.type == UHID_GET_REPORT) {
      uhid_event answer{};
      answer.type = UHID_GET_REPORT_REPLY;
      answer.u.get_report_reply.id = event.u.get_report.id;
      answer.u.get_report_reply.err = EIO;
      write(answer);
    } else if (event.type == UHID_SET_REPORT) {  // a feature report: its id, then its data
      const uhid_set_report_req& asked = event.u.set_report;
      if (model_.receive && asked.size > 0)
        model_.receive({asked.rnum, Bytes(asked.data + 1, asked.data + asked.size)}, host_state_);
      uhid_event answer{};
      answer.type = UHID_SET_REPORT_REPLY;
      answer.u.set_report_reply.id = asked.id;
      answer.u.set_report_reply.err = model_.receive ? 0 : EIO;
      write(answer);
    }
  }

  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) {
      uhid_event event{};
      event.type = UHID_INPUT2;
      // length of the report id; 0 without report ids
      const std::uint16_t head = packet.address == 0 ? 0 : 1;
      event.u.input2.data[0] = static_cast<std::uint8_t>(packet.address);
      event.u.input2.size =
          static_cast<std::uint16_t>(head + std::min<std::size_t>(packet.bytes.size(), UHID_DATA_MAX - 1));
      std::copy_n(packet.bytes.begin(), event.u.input2.size - head, event.u.input2.data + head);
      write(event);
    }
  }

  void plug() override {
    if (plugged_) return;
    uhid_event event{};
    event.type = UHID_CREATE2;
    uhid_create2_req& made = event.u.create2;
    set_text(made.name, model_.summary);
    set_text(made.uniq, serial_);
    made.bus = BUS_USB;
    made.vendor = model_.hid->vendor;
    made.product = model_.hid->product;
    made.rd_size = static_cast<std::uint16_t>(model_.hid->report_descriptor.size());
    std::ranges::copy(model_.hid->report_descriptor, made.rd_data);
    write(event);
    start();
  }

  void unplug() override {
    if (!plugged_) return;
    uhid_event event{};
    event.type = UHID_DESTROY;
    (void)!::write(fd_.get(), &event, sizeof event);  // closing the descriptor destroys the device as well
    plugged_ = false;
  }

  std::string place() const override { return "/dev/uhid"; }

 private:
  void write(const uhid_event& event) {
    checked(static_cast<int>(::write(fd_.get(), &event, sizeof event)), "write to /dev/uhid");
  }

  std::string serial_;
  Fd fd_;
};

}  // namespace

std::unique_ptr<Port> make_uhid_port(const DeviceModel& model, const std::string& serial) {
  return std::make_unique<UhidPort>(model, serial);
}

}  // namespace slipd::devices
