// simulated-device: connects a simulated device to a bus of this machine and runs it until it receives the
// order to quit.
//   simulated-device xela-xr1944 --at can:vcan0 --truth truth.jsonl --control /tmp/device
//   echo "lose 3" | socat - UNIX-SENDTO:/tmp/device
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/devices/contacts.hpp"

namespace {

using namespace slipd::devices;

// Datagrams, each an order. Its own thread, which ends with the program.
void listen_for_orders(const std::string& path, DeviceSimulator& simulator) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ::unlink(path.c_str());
  const int fd = checked(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0), "control socket");
  checked(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), "control socket " + path);
  std::thread([fd, &simulator] {
    char text[256];
    for (;;) {
      const ssize_t length = ::recv(fd, text, sizeof text, 0);
      try {
        if (length > 0) simulator.order(std::string(text, static_cast<std::size_t>(length)));
      } catch (const std::exception& error) {
        std::cerr << "simulated-device: " << error.what() << std::endl;
      }
    }
  }).detach();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Plays a simulated tactile device on a bus of this machine"};
  std::string name, place, truth_file, control, script, weights_file, serial = "SIM0001";
  std::vector<std::string> orders;
  double rate_hz = 0;
  bool with_pattern = false;
  std::uint64_t scans = 0;
  app.add_option("model", name, "its name; --help lists them")->required();
  app.add_option("--at", place,
                 "can:INTERFACE, fd:N, usbip:PORT, uhid, tcp:PORT, pty:PATH, tty:PATH or adapter:PATH")
      ->required();
  app.add_option("--rate-hz", rate_hz, "scans a second, unless the device's own")->check(CLI::PositiveNumber);
  app.add_option("--scans", scans, "quit after so many");
  app.add_option("--script", script, "a JSON file of driver sim's options: contact, cycle, noise");
  app.add_flag("--pattern", with_pattern, "no contact but a fixed pattern in which every taxel differs");
  app.add_option("--weights", weights_file,
                 "what lies on it, a file read before each scan: forces along x, y, normal (N), place (mm)");
  app.add_option("--truth", truth_file, "write what was sent here, a line of JSON a frame");
  app.add_option("--do", orders, "an order at a scan: '100 lose 3'");
  app.add_option("--control", control, "take orders as datagrams on this Unix socket");
  app.add_option("--serial", serial, "serial number on USB and HID");
  std::string models;
  for (const DeviceModel* model : all_models())
    models += "\n  " + std::string(model->name) + "  " + std::string(model->summary);
  app.footer("Models:" + models +
             "\nOrders: lose, reorder, repeat, garbage, shorten, lengthen, stall, unplug, plug, quit");
  CLI11_PARSE(app, argc, argv);

  try {
    const DeviceModel* model = find_model(name);
    if (model == nullptr)
      throw std::invalid_argument("no device is called '" + name + "'; there are:" + models);
    std::ofstream truth;
    if (!truth_file.empty()) truth.open(truth_file);
    if (!truth_file.empty() && !truth) throw std::invalid_argument("cannot write " + truth_file);

    if (rate_hz <= 0) rate_hz = model->rate_hz;
    const auto options =
        script.empty() ? nlohmann::json::object() : nlohmann::json::parse(std::ifstream(script));
    std::vector<Contact> contacts = with_pattern           ? pattern(*model)
                                    : weights_file.empty() ? scripted(*model, rate_hz, options)
                                                           : weights(*model, weights_file);
    DeviceSimulator simulator(*model, std::move(contacts), make_port(*model, place, serial),
                              truth_file.empty() ? nullptr : &truth);
    for (const std::string& order : orders) {
      std::size_t length = 0;
      const auto scan = std::stoull(order, &length);
      simulator.order_at(scan, order.substr(length));
    }
    if (!control.empty()) listen_for_orders(control, simulator);

    std::cout << "ready: " << model->summary << " at " << simulator.port().place() << std::endl;
    simulator.run({}, rate_hz, scans);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "simulated-device: " << error.what() << "\n";
    return 1;
  }
}
