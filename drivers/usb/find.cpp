#include "drivers/usb/find.hpp"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

namespace slipd::usb {
namespace {

constexpr int kDeepest = 7;  // tiers of hubs that the standard allows

std::string id_text(std::uint16_t vendor, std::uint16_t product) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x", vendor, product);
  return text.data();
}

// The kernel's name of the port in /sys/bus/usb/devices.
std::string port_text(libusb_device* device) {
  std::array<std::uint8_t, kDeepest> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), kDeepest);
  std::string text = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i)
    text += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return text;
}

struct Candidate {
  libusb_device* device = nullptr;
  std::unique_ptr<libusb_device_handle, ClosesDevice> handle;
  std::string id, port, serial;
  int refusal = 0;  // why it cannot be opened

  std::string text() const {
    return id + " at port " + port +
           (refusal != 0 ? std::string(" (") + libusb_strerror(refusal) + ")" : " (serial " + serial + ")");
  }
};

std::string joined(const std::vector<Candidate>& list) {
  std::string out;
  for (const Candidate& one : list) out += (out.empty() ? "" : ", ") + one.text();
  return out.empty() ? "none" : out;
}

bool matches(const decode::UsbMatch& match, const libusb_device_descriptor& about) {
  return std::ranges::any_of(match.devices, [&](const decode::HidMatch& device) {
    return device.vendor == about.idVendor && device.product == about.idProduct;
  });
}

std::vector<Candidate> candidates_of(libusb_device** list, ssize_t count, const decode::UsbMatch& match) {
  std::vector<Candidate> out;
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor about{};
    libusb_get_device_descriptor(list[i], &about);
    if (!matches(match, about)) continue;
    Candidate& one = out.emplace_back();
    one.device = list[i];
    one.id = id_text(about.idVendor, about.idProduct);
    one.port = port_text(list[i]);
    libusb_device_handle* handle = nullptr;
    one.refusal = libusb_open(list[i], &handle);
    one.handle.reset(handle);
    if (handle == nullptr || about.iSerialNumber == 0) continue;
    std::array<unsigned char, 128> serial{};
    const int size = libusb_get_string_descriptor_ascii(handle, about.iSerialNumber, serial.data(),
                                                        static_cast<int>(serial.size()));
    if (size > 0) one.serial.assign(serial.begin(), serial.begin() + size);
  }
  return out;
}

std::string wanted_text(const decode::UsbMatch& match, const DeviceSelector& selector) {
  std::string ids;
  for (const auto& device : match.devices)
    ids += (ids.empty() ? "" : " or ") + id_text(device.vendor, device.product);
  return "USB device " + ids + (selector.serial.empty() ? "" : " of serial " + selector.serial) +
         (selector.port.empty() ? "" : " at port " + selector.port);
}

}  // namespace

void ExitsContext::operator()(libusb_context* context) const noexcept {
  libusb_exit(context);
}

void ClosesDevice::operator()(libusb_device_handle* handle) const noexcept {
  libusb_close(handle);
}

FoundDevice find_device(const decode::UsbMatch& match, const DeviceSelector& selector) {
  const std::string wanted = wanted_text(match, selector);
  libusb_context* raw = nullptr;
  if (const int code = libusb_init(&raw); code != 0)
    throw DriverError(wanted + ": libusb does not start: " + libusb_strerror(code) +
                      "; a service needs AF_NETLINK for it, see 50-usb.conf");
  FoundDevice found;
  found.context.reset(raw);

  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(raw, &list);
  std::vector<Candidate> all = candidates_of(list, std::max<ssize_t>(count, 0), match);
  if (list != nullptr) libusb_free_device_list(list, 1);  // a handle holds its device
  const std::string there = joined(all);

  std::erase_if(all, [&](const Candidate& one) {
    const bool other_serial = !selector.serial.empty() && one.refusal == 0 && one.serial != selector.serial;
    return other_serial || (!selector.port.empty() && one.port != selector.port);
  });
  if (all.empty()) {
    throw DriverError(wanted + " is not there; there are: " + there +
                      ". Plug it in, or correct the sensor's device");
  }
  if (all.size() > 1)
    throw DriverError(wanted + ": there are several: " + there +
                      "; name one by device.serial or device.port");
  Candidate& one = all.front();
  if (!one.handle) {
    throw DriverError(wanted + " at port " + one.port + " cannot be opened: " + libusb_strerror(one.refusal) +
                      "; may slipd use it? See 60-slipd-usb.rules");
  }
  found.handle = std::move(one.handle);
  found.id = one.id;
  found.port = one.port;
  found.serial = one.serial;
  return found;
}

}  // namespace slipd::usb
