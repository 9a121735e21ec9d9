#include "tests/drivers/contract/fake_hidapi.hpp"

#include <hidapi/hidapi.h>

using slipd::devices::MemoryBus;
using slipd::devices::Packet;

namespace {

std::shared_ptr<MemoryBus> bus;
const slipd::devices::DeviceModel* model = nullptr;
char path[] = "/dev/fake";
wchar_t serial[] = L"SIM0001", trouble[] = L"nothing is plugged in";

}  // namespace

struct hid_device_ {
  std::shared_ptr<MemoryBus> bus;
};

namespace slipd::test {

void plug_into_fake_hidapi(const devices::DeviceModel& which, std::shared_ptr<MemoryBus> onto) {
  model = &which;
  bus = std::move(onto);
}

}  // namespace slipd::test

extern "C" {

hid_device_info* hid_enumerate(unsigned short, unsigned short) {
  if (!bus || !bus->plugged()) return nullptr;
  auto* info = new hid_device_info{};
  info->path = path;
  info->vendor_id = model->hid->vendor;
  info->product_id = model->hid->product;
  info->serial_number = serial;
  return info;
}

void hid_free_enumeration(hid_device_info* list) {
  delete list;
}

hid_device* hid_open_path(const char*) {
  return bus->plugged() ? new hid_device_{bus} : nullptr;
}

void hid_close(hid_device* device) {
  delete device;
}

const wchar_t* hid_error(hid_device*) {
  return trouble;
}

int hid_write(hid_device* device, const unsigned char* data, std::size_t length) {
  device->bus->say({data[0], {data + 1, data + length}});
  return static_cast<int>(length);
}

int hid_send_feature_report(hid_device* device, const unsigned char* data, std::size_t length) {
  return hid_write(device, data, length);
}

int hid_read_timeout(hid_device* device, unsigned char* data, std::size_t length, int milliseconds) {
  try {
    const auto packet = device->bus->receive(std::chrono::milliseconds(milliseconds));
    if (!packet) return 0;
    const std::size_t head = packet->address == 0 ? 0 : 1;  // the report's id, where there are any
    if (head == 1) data[0] = static_cast<unsigned char>(packet->address);
    const std::size_t size = std::min(packet->bytes.size(), length - head);
    std::copy_n(packet->bytes.begin(), size, data + head);
    return static_cast<int>(head + size);
  } catch (const MemoryBus::Gone&) {
    return -1;
  }
}
}
