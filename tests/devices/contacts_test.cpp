// The truth that a device records belongs to the same contact as the bytes that it sends.
#include "tests/devices/contacts.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <sys/socket.h>

#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <vector>

#include "tests/support/temp_folder.hpp"

namespace slipd::devices {
namespace {

// Gripped with 2 N, sheared along x up to sliding within 100 scans.
const auto kSlip = nlohmann::json::parse(
    R"({ "noise": 0, "cycle": [ { "ms": 1000, "normal_n": 2, "load": [0, 1], "friction": 0.4 } ] })");

std::vector<nlohmann::json> lines(const std::string& text) {
  std::istringstream in(text);
  std::vector<nlohmann::json> out;
  for (std::string line; std::getline(in, line);) out.push_back(nlohmann::json::parse(line));
  return out;
}

TEST(Truth, FallsFromOneToZeroWhileTheContactIsSheared) {
  int pair[2];
  checked(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), "socketpair");
  const Fd host(pair[0]);
  std::ostringstream truth;
  DeviceSimulator simulator(xela_xr1944(), scripted(xela_xr1944(), 100, kSlip),
                            make_can_port(xela_xr1944(), pair[1]), &truth);
  can_frame start{};
  start.can_id = 0x201;
  start.len = 2;
  start.data[0] = 7;
  ASSERT_GT(::send(host.get(), &start, sizeof start, 0), 0);
  simulator.port().serve();

  double last = 1;
  for (int scan = 0; scan < 99; ++scan) {
    simulator.step();
    // Shear and normal force of the counts agree with the truth, to the sensor's resolution.
    double x_n = 0, z_n = 0;
    for (can_frame frame{}; ::recv(host.get(), &frame, sizeof frame, MSG_DONTWAIT) > 0;) {
      constexpr double area_m2 = 0.0047 * 0.0047;
      const auto counts = [&](int at) { return (frame.data[at] << 8 | frame.data[at + 1]) - 30000; };
      x_n += counts(1) * 20 * area_m2;
      z_n += counts(5) * 40 * area_m2;
    }
    const auto said = lines(truth.str()).back();
    constexpr double resolution_n = 16 * 40 * 0.5 * 0.0047 * 0.0047;
    EXPECT_NEAR(z_n, said["normal_n"].get<double>(), resolution_n);
    EXPECT_NEAR(x_n, said["shear_n"].get<double>(), resolution_n);
    EXPECT_DOUBLE_EQ(said["friction"].get<double>(), 0.4);
    EXPECT_LT(said["gamma"].get<double>(), last);
    last = said["gamma"].get<double>();
  }
  EXPECT_NEAR(last, 0.01, 1e-6);
}

TEST(Truth, IsTheSameForEverySensorOfADevice) {
  std::ostringstream truth;
  DeviceSimulator simulator(onrobot_rg2ft(), scripted(onrobot_rg2ft(), 100, kSlip),
                            make_modbus_tcp_port(onrobot_rg2ft(), 0), &truth);
  for (int scan = 0; scan < 50; ++scan) simulator.step();
  const auto said = lines(truth.str());
  ASSERT_EQ(said.size(), 100);
  EXPECT_EQ(said[98]["sensor"], 0);
  EXPECT_EQ(said[99]["sensor"], 1);
  EXPECT_NEAR(said[99]["normal_n"].get<double>(), 2, 1e-4);
  EXPECT_EQ(said[98]["gamma"], said[99]["gamma"]);
}

// Forces of a frame in N, and where the normal one acts, mm.
struct Felt {
  double x_n = 0, y_n = 0, normal_n = 0, at_x_mm = 0;
};

Felt felt(const Contact& contact, const TaxelLayout& layout) {
  std::vector<float> memory(3 * layout.size());
  const std::span all(memory);
  FrameSlot slot;
  slot.normal_pa = all.subspan(0, layout.size());
  slot.shear_x_pa = all.subspan(layout.size(), layout.size());
  slot.shear_y_pa = all.subspan(2 * layout.size(), layout.size());
  contact(slot);
  Felt sums;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double normal_n = slot.normal_pa[i] * layout.area_m2();
    sums.x_n += slot.shear_x_pa[i] * layout.area_m2();
    sums.y_n += slot.shear_y_pa[i] * layout.area_m2();
    sums.normal_n += normal_n;
    sums.at_x_mm += 1e3 * layout.x_m()[i] * normal_n;
  }
  sums.at_x_mm /= sums.normal_n;
  return sums;
}

TEST(Weights, LieWhereTheirFileSaysFromTheNextScanOn) {
  const testing::TempFolder folder;
  const Contact contact = weights(xela_xr1944(), folder.file("load")).at(0);
  constexpr double kFiveSigmasN = 0.1;
  EXPECT_NEAR(felt(contact, xela_xr1944().layout).normal_n, 0, kFiveSigmasN);
  folder.write("load", "0.5 -1 4 -7.05 -7.05");
  const Felt loaded = felt(contact, xela_xr1944().layout);
  EXPECT_NEAR(loaded.x_n, 0.5, kFiveSigmasN);
  EXPECT_NEAR(loaded.y_n, -1, kFiveSigmasN);
  EXPECT_NEAR(loaded.normal_n, 4, kFiveSigmasN);
  EXPECT_LT(loaded.at_x_mm, -4);
}

}  // namespace
}  // namespace slipd::devices
