// reopen MODULE SETUP TIMES: loads a driver's module as slipd does, and opens and closes its device TIMES
// times, twice. SETUP is JSON: {"profile", "device", "options"}. Exits with 0 if the first and the last
// opening gave frames and neither descriptors nor memory leaked between: a leak grows in each series of
// openings, a buffer that a busy host makes longer in one.
#include <dlfcn.h>
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "driver_api/driver.hpp"

namespace {

using namespace slipd;

constexpr int kReads = 500;          // reads of 20 ms to wait for a first frame
constexpr std::size_t kLeaked = 24;  // bytes an opening: less than a leak of the smallest object

std::ptrdiff_t descriptors() {
  namespace fs = std::filesystem;
  return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
}

class Device {
 public:
  explicit Device(std::unique_ptr<DeviceDriver> driver) : driver_(std::move(driver)) {}

  void cycle() {
    driver_->open();
    driver_->close();
  }

  bool gives_frames() {
    const DeviceInfo info = driver_->open();
    const std::size_t taxels = info.sensors[0].layout.size();
    std::vector<float> memory(3 * taxels);
    FrameSlot slot;
    slot.normal_pa = std::span(memory).first(taxels);
    slot.shear_x_pa = std::span(memory).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(memory).last(taxels);
    bool seen = false;
    for (int i = 0; i < kReads && !seen; ++i)
      seen = driver_->read({&slot, 1}, std::chrono::milliseconds(20)).status == ReadStatus::frame;
    driver_->close();
    return seen;
  }

 private:
  std::unique_ptr<DeviceDriver> driver_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) return 2;
  void* const module = ::dlopen(argv[1], RTLD_NOW);
  if (module == nullptr) throw std::runtime_error(::dlerror());
  const auto table = reinterpret_cast<const DriverModule* (*)()>(::dlsym(module, kDriverSymbol));
  const auto asked = nlohmann::json::parse(argv[2]);
  const SensorSetup setup{.name = "sensor",
                          .layout = TaxelLayout::wrench(0.01),
                          .rate_hz = 100,
                          .profile = asked.at("profile"),
                          .device = asked.at("device"),
                          .options = asked.at("options")};
  Device device(table()->create({setup}));

  const auto times = std::stoul(argv[3]);
  bool well = device.gives_frames();
  // The threads of libusb and libudev allocate memory during the first openings, even without a device, and
  // keep it.
  constexpr unsigned long kSeries = 3;
  const auto each = 2 * times / (kSeries + 1);
  const auto open = [&] {
    for (unsigned long i = 0; i < each; ++i) device.cycle();
  };
  open();
  const std::ptrdiff_t open_before = descriptors();
  std::size_t bytes = ::mallinfo2().uordblks, least_growth = bytes;
  for (unsigned long series = 0; series < kSeries; ++series) {
    open();
    const std::size_t bytes_now = ::mallinfo2().uordblks;
    least_growth = std::min(least_growth, bytes_now > bytes ? bytes_now - bytes : 0);
    bytes = bytes_now;
  }
  const std::ptrdiff_t open_after = descriptors();
  well = well && device.gives_frames();
  std::printf(
      "%lu series of %lu openings: %zd descriptors before, %zd after; each took %zu bytes or more; frames: "
      "%s\n",
      kSeries, each, open_before, open_after, least_growth, well ? "yes" : "no");
  return well && open_after <= open_before && least_growth < kLeaked * each ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "reopen: %s\n", error.what());
  return 1;
}
