// usb-client VENDOR PRODUCT INTERFACE COUNT [SETUP DATA]: opens the USB device as driver usb does, by
// libusb, detaches the kernel's driver if there is one, starts the device, writes COUNT bulk transfers from
// endpoint 0x81 to stdout in hexadecimal, then reads until the device is gone. Exits with 0 when both have
// happened. The start is `control REQUEST VALUE` (a vendor request with a byte to the host) or `bulk HEX`
// (to endpoint 0x01).
#include <libusb-1.0/libusb.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr unsigned kTimeoutMs = 5000;

int fail(const char* what, int code) {
  std::fprintf(stderr, "%s: %s\n", what, libusb_strerror(code));
  return 1;
}

int start(libusb_device_handle* device, const std::string& how, const char* first, const char* second) {
  if (how == "control") {
    unsigned char answer = 0;
    return libusb_control_transfer(device, 0xC0, static_cast<std::uint8_t>(std::strtoul(first, nullptr, 16)),
                                   static_cast<std::uint16_t>(std::strtoul(second, nullptr, 10)), 0xFF,
                                   &answer, 1, kTimeoutMs);
  }
  std::vector<unsigned char> bytes;
  for (std::size_t i = 0; i + 1 < std::strlen(first); i += 2) {
    bytes.push_back(static_cast<unsigned char>(std::strtoul(std::string(first + i, 2).c_str(), nullptr, 16)));
  }
  int sent = 0;
  return libusb_bulk_transfer(device, 0x01, bytes.data(), static_cast<int>(bytes.size()), &sent, kTimeoutMs);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  libusb_init(nullptr);
  libusb_device_handle* device =
      libusb_open_device_with_vid_pid(nullptr, static_cast<std::uint16_t>(std::strtoul(argv[1], nullptr, 16)),
                                      static_cast<std::uint16_t>(std::strtoul(argv[2], nullptr, 16)));
  if (device == nullptr) {
    std::fprintf(stderr, "libusb sees no %s:%s\n", argv[1], argv[2]);
    return 1;
  }
  libusb_device_descriptor about{};
  libusb_get_device_descriptor(libusb_get_device(device), &about);
  unsigned char text[128] = {};
  libusb_get_string_descriptor_ascii(device, about.iProduct, text, sizeof text);
  std::printf("product %s\n", reinterpret_cast<const char*>(text));
  libusb_get_string_descriptor_ascii(device, about.iSerialNumber, text, sizeof text);
  std::printf("serial %s\n", reinterpret_cast<const char*>(text));

  libusb_set_auto_detach_kernel_driver(device, 1);
  if (const int code = libusb_claim_interface(device, std::atoi(argv[3])); code != 0)
    return fail("claim", code);
  if (argc > 6) {
    const int code = start(device, argv[5], argv[6], argc > 7 ? argv[7] : "");
    if (code < 0) return fail("start", code);
  }
  unsigned char data[4096];
  int size = 0, code = 0;
  for (int left = std::atoi(argv[4]); left > 0; --left) {
    code = libusb_bulk_transfer(device, 0x81, data, sizeof data, &size, kTimeoutMs);
    if (code != 0) return fail("bulk IN", code);
    for (int i = 0; i < size; ++i) std::printf("%02x", data[i]);
    std::printf("\n");
  }
  std::printf("reading on\n");
  std::fflush(stdout);
  while (code == 0) code = libusb_bulk_transfer(device, 0x81, data, sizeof data, &size, kTimeoutMs);
  std::printf("ended by %s\n", libusb_error_name(code));
  libusb_close(device);
  libusb_exit(nullptr);
  return code == LIBUSB_ERROR_NO_DEVICE || code == LIBUSB_ERROR_IO ? 0 : 1;
}
