// hid-client VENDOR PRODUCT COUNT: opens the HID device as driver hid does, by hidapi's hidraw backend,
// writes COUNT reports to stdout in hexadecimal, then reads until the device is gone. Exits with 0 when both
// have happened.
#include <hidapi/hidapi.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto vendor = static_cast<unsigned short>(std::strtoul(argv[1], nullptr, 16));
  const auto product = static_cast<unsigned short>(std::strtoul(argv[2], nullptr, 16));
  const std::unique_ptr<hid_device_info, decltype(&hid_free_enumeration)> found(
      hid_enumerate(vendor, product), hid_free_enumeration);
  if (!found) {
    std::fprintf(stderr, "hidapi sees no %s:%s\n", argv[1], argv[2]);
    return 1;
  }
  std::printf("product %ls\nserial %ls\n", found->product_string, found->serial_number);
  const std::unique_ptr<hid_device, decltype(&hid_close)> device(hid_open_path(found->path), hid_close);
  if (!device) {
    std::fprintf(stderr, "%s: %ls\n", found->path, hid_error(nullptr));
    return 1;
  }
  unsigned char report[65];
  for (int left = std::atoi(argv[3]); left > 0; --left) {
    const int size = hid_read_timeout(device.get(), report, sizeof report, 5000);
    if (size <= 0) return 1;
    for (int i = 0; i < size; ++i) std::printf("%02x", report[i]);
    std::printf("\n");
  }
  std::printf("reading on\n");
  std::fflush(stdout);
  while (hid_read_timeout(device.get(), report, sizeof report, 5000) > 0) {
  }
  std::printf("gone\n");
  return 0;
}
