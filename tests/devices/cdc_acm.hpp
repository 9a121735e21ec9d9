// The USB face of a device that looks like a serial port: communication interface 0 with an interrupt
// endpoint, data interface 1 with bulk IN 0x81 and OUT 0x01.
#pragma once

#include "tests/devices/device_model.hpp"

namespace slipd::devices {

inline UsbModel cdc_acm(std::uint16_t vendor, std::uint16_t product) {
  return {
      .vendor = vendor,
      .product = product,
      .device_class = 2,
      .in_endpoint = 0x81,
      .configuration = {9, 2,    0,    0,    2,  1,  0,   0x80, 100,  //
                        9, 4,    0,    0,    1,  2,  2,   1,    0,    // communication, abstract control model
                        5, 0x24, 0,    0x10, 1,                       // CDC 1.10
                        5, 0x24, 1,    0,    1,                       // no call management
                        4, 0x24, 2,    2,                             // line coding and state
                        5, 0x24, 6,    0,    1,                       // union of 0 and 1
                        7, 5,    0x82, 3,    16, 0,  255,             // interrupt IN: notifications
                        9, 4,    1,    0,    2,  10, 0,   0,    0,    // data
                        7, 5,    0x81, 2,    64, 0,  0,               // bulk IN
                        7, 5,    0x01, 2,    64, 0,  0},              // bulk OUT
      .request = [](const UsbRequest& asked, HostState&) -> std::optional<Bytes> {
        constexpr std::uint8_t kSetLineCoding = 0x20, kGetLineCoding = 0x21, kSetLineState = 0x22;
        if (asked.request == kGetLineCoding) return Bytes{0x00, 0xC2, 0x01, 0x00, 0, 0, 8};  // 115200 8N1
        if (asked.request == kSetLineCoding || asked.request == kSetLineState) return Bytes{};
        return std::nullopt;
      }};
}

}  // namespace slipd::devices
