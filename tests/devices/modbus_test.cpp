// Modbus slaves on loopback and on a pseudo-terminal, asked by libmodbus' client as a driver would.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <unistd.h>

#include <cerrno>
#include <thread>

#include "tests/devices/contacts.hpp"

namespace slipd::devices {
namespace {

using ::testing::ElementsAre;

struct Closes {
  void operator()(modbus_t* it) const {
    modbus_close(it);
    modbus_free(it);
  }
};
using Client = std::unique_ptr<modbus_t, Closes>;

// A simulated device on a thread of its own, 500 scans a second.
class Running {
 public:
  Running(const DeviceModel& model, std::unique_ptr<Port> port)
      : simulator_(model, pattern(model), std::move(port)),
        thread_([this](std::stop_token stop) { simulator_.run(stop, 500); }) {}
  DeviceSimulator& simulator() { return simulator_; }
  std::string place() { return simulator_.port().place(); }

 private:
  DeviceSimulator simulator_;
  std::jthread thread_;
};

Client connected(modbus_t* context, int unit) {
  Client client(context);
  modbus_set_slave(client.get(), unit);
  // Longer than any answer takes; tests that wait for silence set a shorter time.
  modbus_set_response_timeout(client.get(), 60, 0);
  if (modbus_connect(client.get()) != 0) client.reset();
  return client;
}

Client rg2ft_client(Running& device) {
  return connected(modbus_new_tcp("127.0.0.1", std::stoi(device.place())), 65);
}

// Reads until `done` accepts the registers; an order takes effect within milliseconds.
template <class Done>
int read_until(modbus_t* client, int first, int count, std::vector<std::uint16_t>& out, Done&& done) {
  int got = -1;
  for (int attempt = 0; attempt < 2000; ++attempt) {
    out.assign(static_cast<std::size_t>(count), 0);
    errno = 0;
    got = modbus_read_registers(client, first, count, out.data());
    if (done(got)) return got;
    std::this_thread::yield();
  }
  ADD_FAILURE() << "waited in vain";
  return got;
}

TEST(ModbusTcp, AnswersWithTheForcesOfBothFingers) {
  Running device(onrobot_rg2ft(), make_modbus_tcp_port(onrobot_rg2ft(), 0));
  const Client client = rg2ft_client(device);
  ASSERT_TRUE(client);
  std::vector<std::uint16_t> got;
  read_until(client.get(), 257, 26, got, [&](int n) { return n == 26 && got[4] != 0; });
  EXPECT_THAT(std::vector(got.begin() + 2, got.begin() + 5), ElementsAre(2, 0xFFFF, 3));
  EXPECT_THAT(std::vector(got.begin() + 11, got.begin() + 14), ElementsAre(2, 0xFFFF, 4));
}

TEST(ModbusTcp, RefusesRegistersThatItDoesNotHave) {
  Running device(onrobot_rg2ft(), make_modbus_tcp_port(onrobot_rg2ft(), 0));
  const Client client = rg2ft_client(device);
  ASSERT_TRUE(client);
  std::uint16_t one = 0;
  EXPECT_EQ(modbus_read_registers(client.get(), 256, 1, &one), -1);
  EXPECT_EQ(errno, EMBXILADD);
}

TEST(ModbusTcp, HangsUpWhenUnpluggedAndIsThereAgain) {
  Running device(onrobot_rg2ft(), make_modbus_tcp_port(onrobot_rg2ft(), 0));
  Client client = rg2ft_client(device);
  ASSERT_TRUE(client);
  std::vector<std::uint16_t> got;
  device.simulator().order("unplug");
  read_until(client.get(), 257, 26, got, [](int n) { return n < 0; });
  EXPECT_FALSE(rg2ft_client(device)) << "nobody listens";
  device.simulator().order("plug");
  while (!(client = rg2ft_client(device))) std::this_thread::yield();
  read_until(client.get(), 257, 26, got, [](int n) { return n == 26; });
}

TEST(ModbusTcp, LeavesARequestUnansweredWhileItStalls) {
  Running device(onrobot_rg2ft(), make_modbus_tcp_port(onrobot_rg2ft(), 0));
  const Client client = rg2ft_client(device);
  ASSERT_TRUE(client);
  std::vector<std::uint16_t> got;
  modbus_set_response_timeout(client.get(), 0, 100'000);
  device.simulator().order("stall 1000000");
  read_until(client.get(), 257, 26, got, [](int n) { return n < 0 && errno == ETIMEDOUT; });
}

TEST(ModbusTcp, OfTheWrongLengthIsAnException) {
  Running device(onrobot_rg2ft(), make_modbus_tcp_port(onrobot_rg2ft(), 0));
  const Client client = rg2ft_client(device);
  ASSERT_TRUE(client);
  std::vector<std::uint16_t> got;
  device.simulator().order("shorten 100");
  read_until(client.get(), 257, 26, got, [](int n) { return n < 0 && errno == EMBXILADD; });
}

TEST(ModbusRtu, AnswersOnAPseudoTerminal) {
  const std::string link = ::testing::TempDir() + "/slipd-ft300-" + std::to_string(::getpid());
  Running device(robotiq_ft300(), make_modbus_pty_port(robotiq_ft300(), link));
  const Client client = connected(modbus_new_rtu(link.c_str(), 19200, 'N', 8, 1), 9);
  ASSERT_TRUE(client) << modbus_strerror(errno);
  std::vector<std::uint16_t> got;
  read_until(client.get(), 180, 6, got, [&](int n) { return n == 6 && got[2] != 0; });
  EXPECT_THAT(got, ElementsAre(20, 0xFFF6, 40, 0, 0, 0));
}

TEST(ModbusRtu, GoesAwayWhenUnpluggedAndIsThereAgain) {
  const std::string link = ::testing::TempDir() + "/slipd-ft300-unplugged-" + std::to_string(::getpid());
  Running device(robotiq_ft300(), make_modbus_pty_port(robotiq_ft300(), link));
  Client client = connected(modbus_new_rtu(link.c_str(), 19200, 'N', 8, 1), 9);
  ASSERT_TRUE(client);
  std::vector<std::uint16_t> got;
  device.simulator().order("unplug");
  read_until(client.get(), 180, 6, got, [](int n) { return n < 0; });
  EXPECT_NE(::access(link.c_str(), F_OK), 0) << "the link is gone with it";
  device.simulator().order("plug");
  while (!(client = connected(modbus_new_rtu(link.c_str(), 19200, 'N', 8, 1), 9))) std::this_thread::yield();
  read_until(client.get(), 180, 6, got, [](int n) { return n == 6; });
}

TEST(ModbusRtu, IsDeafToOtherUnits) {
  const std::string link = ::testing::TempDir() + "/slipd-ft300-other-" + std::to_string(::getpid());
  Running device(robotiq_ft300(), make_modbus_pty_port(robotiq_ft300(), link));
  const Client client = connected(modbus_new_rtu(link.c_str(), 19200, 'N', 8, 1), 10);
  ASSERT_TRUE(client);
  modbus_set_response_timeout(client.get(), 0, 100'000);
  std::uint16_t got[6];
  EXPECT_EQ(modbus_read_registers(client.get(), 180, 6, got), -1);
  EXPECT_EQ(errno, ETIMEDOUT);
}

}  // namespace
}  // namespace slipd::devices
