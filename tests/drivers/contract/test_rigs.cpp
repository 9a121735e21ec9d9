#include <dlfcn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "drivers/can/can_driver.hpp"
#include "drivers/hid/hid_driver.hpp"
#include "drivers/modbus/modbus_driver.hpp"
#include "drivers/replay/replay_driver.hpp"
#include "drivers/sim/sim_driver.hpp"
#include "tests/devices/contacts.hpp"
#include "tests/drivers/contract/fake_hidapi.hpp"
#include "tests/drivers/contract/memory_transport.hpp"
#include "tests/drivers/contract/test_rig.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::test {
namespace {

using devices::DeviceModel;
using devices::DeviceSimulator;
using devices::MemoryBus;
using nlohmann::json;

// A device that runs on its own thread.
class Running {
 public:
  Running(const DeviceModel& model, std::unique_ptr<devices::Port> port)
      : simulator_(model, devices::pattern(model), std::move(port)),
        thread_([this](std::stop_token stop) { simulator_.run(stop, device_rate_hz); }) {}
  DeviceSimulator& simulator() { return simulator_; }

 private:
  DeviceSimulator simulator_;
  std::jthread thread_;
};

std::vector<SensorSetup> setups(const DeviceModel& model, const std::string& profile, const json& device) {
  std::vector<SensorSetup> out;
  for (std::size_t i = 0; i < model.sensors; ++i) {
    SensorSetup& setup = out.emplace_back(setup_of(TaxelLayout::grid(1, 1, 0.001), {{"sensor", i}}));
    setup.profile = profile;
    setup.device = device;
  }
  return out;
}

// A device that exists before the driver is opened, and stays.
class DeviceTestRig final : public TestRig {
 public:
  using Make = std::function<std::unique_ptr<DeviceDriver>(const std::string& place)>;
  DeviceTestRig(const DeviceModel& model, std::unique_ptr<devices::Port> port, const Make& make)
      : device_(model, std::move(port)), driver_(make(device_.simulator().port().place())) {}
  DeviceDriver& driver() override { return *driver_; }
  void order(const std::string& misbehaviour) override { device_.simulator().order(misbehaviour); }

 private:
  Running device_;
  std::unique_ptr<DeviceDriver> driver_;
};

// A bus that is a pair of sockets; the device sits at the other end of each new pair.
class CanTestRig final : public TestRig {
 public:
  DeviceDriver& driver() override { return driver_; }
  void order(const std::string& misbehaviour) override { device_->simulator().order(misbehaviour); }

 private:
  can::Socket connect() {
    int pair[2];
    devices::checked(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), "socketpair");
    device_.reset();
    device_ = std::make_unique<Running>(devices::xela_xr1944(),
                                        devices::make_can_port(devices::xela_xr1944(), pair[1]));
    return can::Socket(pair[0]);
  }

  std::unique_ptr<Running> device_;
  can::CanDriver driver_{setups(devices::xela_xr1944(), "xela-xr1944", {{"interface", "can0"}}),
                         [this](const std::string&, const std::vector<std::uint32_t>&) { return connect(); }};
};

// A driver that needs no device.
class SoftBench final : public TestRig {
 public:
  explicit SoftBench(std::unique_ptr<DeviceDriver> driver,
                     std::unique_ptr<testing::TempFolder> folder = nullptr)
      : folder_(std::move(folder)), driver_(std::move(driver)) {}
  DeviceDriver& driver() override { return *driver_; }

 private:
  std::unique_ptr<testing::TempFolder> folder_;
  std::unique_ptr<DeviceDriver> driver_;
};

std::unique_ptr<TestRig> modbus_tcp(const DeviceModel& model, const std::string& profile) {
  return std::make_unique<DeviceTestRig>(
      model, devices::make_modbus_tcp_port(model, 0), [&](const std::string& place) {
        return std::make_unique<modbus::ModbusDriver>(
            setups(model, profile, {{"host", "127.0.0.1"}, {"port", std::stoi(place)}}));
      });
}

std::unique_ptr<TestRig> modbus_rtu(const DeviceModel& model, const std::string& profile) {
  const std::string line =
      (std::filesystem::temp_directory_path() / ("slipd-line-" + std::to_string(::getpid()))).string();
  return std::make_unique<DeviceTestRig>(
      model, devices::make_modbus_pty_port(model, line), [&](const std::string&) {
        return std::make_unique<modbus::ModbusDriver>(setups(model, profile, {{"serial_line", line}}));
      });
}

std::unique_ptr<TestRig> usb_device(const DeviceModel& model, const std::string& profile) {
  auto bus = std::make_shared<MemoryBus>();
  return std::make_unique<DeviceTestRig>(
      model, devices::make_memory_port(model, bus), [&](const std::string&) {
        return std::make_unique<usb::UsbDriver>(setups(model, profile, json::object()), memory_opener(bus));
      });
}

std::unique_ptr<TestRig> hid_device(const DeviceModel& model, const std::string& profile) {
  auto bus = std::make_shared<MemoryBus>();
  plug_into_fake_hidapi(model, bus);
  return std::make_unique<DeviceTestRig>(
      model, devices::make_memory_port(model, bus), [&](const std::string&) {
        return std::make_unique<hid::HidDriver>(setups(model, profile, json::object()));
      });
}

std::unique_ptr<TestRig> simulation() {
  const json options{{"noise", 0}, {"cycle", {{{"ms", 1000}, {"normal_n", 2}, {"shear_n", 0.5}}}}};
  return std::make_unique<SoftBench>(
      std::make_unique<sim::SimDriver>(std::vector{setup_of(TaxelLayout::grid(8, 8, 0.001), options, 500)}));
}

std::unique_ptr<TestRig> recording() {
  auto folder = std::make_unique<testing::TempFolder>();
  const auto file = folder->path() / "a.csv";
  std::ofstream(file) << "txl1_x,txl1_y,txl1_z\n1,2,3\n1,2,3\n1,2,3\n";
  const json options{{"file", file.string()}, {"loop", true}};
  auto driver = std::make_unique<replay::ReplayDriver>(
      std::vector{setup_of(TaxelLayout::grid(1, 1, 0.001), options, 500)});
  return std::make_unique<SoftBench>(std::move(driver), std::move(folder));
}

// The skeleton's module, and a program that sends it frames.
class SkeletonBench final : public TestRig {
 public:
  SkeletonBench() {
    using Table = const DriverModule* (*)();
    const char* file = SLIPD_BINARY_DIR "/test-drivers/slipd-driver-skeleton.so";
    module_.reset(::dlopen(file, RTLD_NOW));
    if (!module_) throw std::runtime_error(::dlerror());
    const auto table = reinterpret_cast<Table>(::dlsym(module_.get(), kDriverSymbol));
    driver_ = table()->create({setup_of(TaxelLayout::grid(2, 2, 0.001), {{"path", path_.string()}})});
    sender_ = std::jthread([this](const std::stop_token& stop) { send(stop); });
  }
  DeviceDriver& driver() override { return *driver_; }

 private:
  struct Unloads {
    void operator()(void* module) const { ::dlclose(module); }
  };

  void send(const std::stop_token& stop) const {
    const devices::Fd fd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    std::vector<char> frame(4 + 3 * 4 * 4, 1);
    for (std::uint32_t count = 0; !stop.stop_requested(); ++count) {
      std::memcpy(frame.data(), &count, sizeof count);
      const std::size_t size = count % 7 == 0 ? 5 : frame.size();  // some are too short
      (void)::sendto(fd.get(), frame.data(), size, MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&address),
                     sizeof address);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  testing::TempFolder folder_;
  std::filesystem::path path_ = folder_.path() / "socket";
  std::unique_ptr<void, Unloads> module_;
  std::unique_ptr<DeviceDriver> driver_;
  std::jthread sender_;
};

}  // namespace

void PrintTo(const DriverCase& driver_case, std::ostream* out) {
  *out << driver_case.name;
}

std::vector<DriverCase> all_driver_cases() {
  return {
      {.name = "sim", .make = simulation, .misbehaves = false},
      {.name = "replay", .make = recording, .misbehaves = false},
      {.name = "skeleton", .make = [] { return std::make_unique<SkeletonBench>(); }, .misbehaves = false},
      {.name = "can", .make = [] { return std::make_unique<CanTestRig>(); }, .sees_unplugging = false},
      {.name = "modbus_tcp",
       .make = [] { return modbus_tcp(devices::onrobot_rg2ft(), "onrobot-rg2-ft"); },
       .knows_losses = false},
      {.name = "modbus_rtu",
       .make = [] { return modbus_rtu(devices::robotiq_ft300(), "robotiq-ft300"); },
       .knows_losses = false},
      {.name = "hid", .make = [] { return hid_device(devices::vendor_hid(), "vendor-hid-8x8"); }},
      {.name = "usb_stream", .make = [] { return usb_device(devices::papillarray(), "contactile-pts2"); }},
      {.name = "hid_numbered",
       .make = [] { return hid_device(devices::space_mouse(), "3dconnexion"); },
       .knows_losses = false},
      {.name = "usb_transfers",
       .make = [] { return usb_device(devices::takktile(), "takktile"); },
       .knows_losses = false},
      {.name = "usb_fixed", .make = [] { return usb_device(devices::optoforce(), "optoforce"); }},
      {.name = "usb_records", .make = [] { return usb_device(devices::robotiq_tsf85(), "robotiq-tsf85"); }},
  };
}

}  // namespace slipd::test
