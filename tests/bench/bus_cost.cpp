// bus-cost [SECONDS]: the cost of reading on each bus, without the bus itself: frames a second and the
// reading thread's CPU time per frame. Simulated devices in the same process send as fast as a timer allows.
// CAN is a pair of sockets; Modbus is loopback and a pseudo-terminal with the real libmodbus; USB and HID
// read from memory, without libusb and hidapi, whose cost the tests in guests show.
#include <sys/utsname.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/drivers/contract/test_rig.hpp"
#include "tests/drivers/driver_fixture.hpp"

namespace {

using namespace slipd;

double seconds_of(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string machine() {
  std::ifstream info("/proc/cpuinfo");
  std::string name = "unknown CPU";
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) name = line.substr(line.find(':') + 2);
  }
  utsname system{};
  ::uname(&system);
  return name + ", " + system.sysname + " " + system.release;
}

void measure(const test::DriverCase& driver_case, double seconds) {
  const auto rig = driver_case.make();
  DeviceDriver& driver = rig->driver();
  const DeviceInfo info = driver.open();
  std::vector<test::OwnedSlot> owned;
  std::vector<FrameSlot> slots;
  for (const SensorInfo& sensor : info.sensors) owned.emplace_back(sensor.layout.size());
  for (auto& one : owned) slots.push_back(one.slot);

  int frames = 0, corrupt = 0;
  const double begun_s = seconds_of(CLOCK_MONOTONIC), cpu_s = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  while (seconds_of(CLOCK_MONOTONIC) < begun_s + seconds) {
    const ReadStatus status = driver.read(slots, std::chrono::milliseconds(20)).status;
    frames += status == ReadStatus::frame ? 1 : 0;
    corrupt += status == ReadStatus::corrupt ? 1 : 0;
  }
  const double wall_s = seconds_of(CLOCK_MONOTONIC) - begun_s;
  const double used_s = seconds_of(CLOCK_THREAD_CPUTIME_ID) - cpu_s;
  std::printf("| %-13s | %6zu | %8.0f | %8.1f | %7d |\n", driver_case.name.c_str(),
              info.sensors[0].layout.size(), frames / wall_s, 1e6 * used_s / std::max(frames, 1), corrupt);
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 3;
  std::printf("%s\n\n", machine().c_str());
  std::printf("| driver        | taxels | frames/s | us/frame | corrupt |\n|---|---|---|---|---|\n");
  slipd::test::device_rate_hz = 20000;
  for (const test::DriverCase& driver_case : test::all_driver_cases()) measure(driver_case, seconds);
  return 0;
}
