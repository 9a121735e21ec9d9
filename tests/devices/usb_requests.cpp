#include "tests/devices/usb_requests.hpp"

namespace slipd::devices {
namespace {

constexpr std::uint8_t kStandard = 0, kTypeMask = 0x60;
constexpr std::size_t kInterfaceClass = 5;  // within an interface descriptor

Bytes text(std::string_view ascii) {
  Bytes out{static_cast<std::uint8_t>(2 + 2 * ascii.size()), 3};
  for (const char c : ascii) put_le(out, static_cast<std::uint16_t>(c));
  return out;
}

}  // namespace

UsbRequests::UsbRequests(const DeviceModel& model, HostState& host, std::string serial)
    : model_(model), host_state_(host), serial_(std::move(serial)), configuration_(model.usb->configuration) {
  configuration_[2] = static_cast<std::uint8_t>(configuration_.size());
  configuration_[3] = static_cast<std::uint8_t>(configuration_.size() >> 8);
}

Bytes UsbRequests::device_descriptor() const {
  Bytes out{18, 1, 0x00, 0x02, model_.usb->device_class, 0, 0, 64};
  put_le(out, model_.usb->vendor);
  put_le(out, model_.usb->product);
  append(out, {0x00, 0x01, 1, 2, 3, 1});  // release 1.00, strings, one configuration
  return out;
}

std::optional<Bytes> UsbRequests::descriptor(std::uint16_t which) const {
  switch (which >> 8) {
    case 1:
      return device_descriptor();
    case 2:
      return configuration_;
    case 3:
      switch (which & 0xFF) {
        case 0:
          return Bytes{4, 3, 0x09, 0x04};  // US English
        case 1:
          return text("simulated");
        case 2:
          return text(model_.summary);
        case 3:
          return text(serial_);
        default:
          return std::nullopt;
      }
    default:
      return std::nullopt;
  }
}

std::optional<Bytes> UsbRequests::control(std::span<const std::uint8_t> setup) {
  const auto word = [&](std::size_t at) {
    return static_cast<std::uint16_t>(setup[at] | setup[at + 1] << 8);
  };
  const UsbRequest asked{setup[0], setup[1], word(2), word(4), word(6)};
  if ((asked.type & kTypeMask) != kStandard) {
    return model_.usb->request ? model_.usb->request(asked, host_state_) : std::nullopt;
  }
  switch (asked.request) {
    case 0:
      return Bytes{0, 0};  // status
    case 6:
      return descriptor(asked.value);
    case 8:
      return Bytes{1};  // the configuration in use
    case 10:
      return Bytes{0};  // the alternate setting in use
    case 1:
    case 3:
    case 9:
    case 11:
      return Bytes{};  // clear or set feature, set configuration or interface
    default:
      return std::nullopt;
  }
}

Bytes UsbRequests::usbip_record(bool with_interfaces) const {
  const auto padded = [](std::string_view ascii, std::size_t size) {
    Bytes out(ascii.begin(), ascii.end());
    out.resize(size, 0);
    return out;
  };
  constexpr std::uint32_t bus = 1, device = 1, full_speed = 2;
  Bytes out = padded("/sys/devices/simulated/1-1", 256);
  append(out, padded("1-1", 32));
  put_be(out, bus);
  put_be(out, device);
  put_be(out, full_speed);
  put_be(out, model_.usb->vendor);
  put_be(out, model_.usb->product);
  put_be(out, std::uint16_t{0x0100});
  append(out, {model_.usb->device_class, 0, 0, 1, 1, configuration_[4]});
  if (!with_interfaces) return out;
  for (std::size_t at = 0; at < configuration_.size(); at += configuration_[at]) {
    if (configuration_[at + 1] != 4) continue;
    const auto of_class = configuration_.begin() + static_cast<std::ptrdiff_t>(at + kInterfaceClass);
    out.insert(out.end(), of_class, of_class + 3);
    out.push_back(0);
  }
  return out;
}

}  // namespace slipd::devices
