// The server without slipd, with libmodbus as its client and with bytes that are no Modbus.
#include "bridges/modbus/server.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <modbus.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "tests/support/patience.hpp"

namespace slipd::modbus {
namespace {

int free_port() {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&at), size), 0);
  getsockname(fd, reinterpret_cast<sockaddr*>(&at), &size);
  close(fd);
  return ntohs(at.sin_port);
}

// The server in a thread of its own.
class Serving {
 public:
  explicit Serving(std::size_t max_clients = 16) : port_(free_port()) {
    ServerSettings settings;
    settings.port = port_;
    settings.max_clients = max_clients;
    settings.blocks = {"left"};
    settings.socket = "/nowhere/slipd.sock";
    thread_ = std::thread([this, settings] {
      bridges::Loop loop;
      const Server server(settings, loop);
      ready_ = true;
      ready_.notify_all();
      while (!ends_) loop.run_once(std::chrono::milliseconds(10));
    });
    ready_.wait(false);
  }
  ~Serving() {
    ends_ = true;
    thread_.join();
  }

  int port() const { return port_; }

  // A connection of plain bytes.
  int plain() const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port_));
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{std::chrono::seconds(testing::kPatience).count(), 0};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
    return fd;
  }

 private:
  int port_;
  std::atomic<bool> ready_{false}, ends_{false};
  std::thread thread_;
};

struct Plc {
  explicit Plc(int port) : context(modbus_new_tcp("127.0.0.1", port)) {
    modbus_set_response_timeout(context, 60, 0);
    EXPECT_EQ(modbus_connect(context), 0);
  }
  ~Plc() {
    modbus_close(context);
    modbus_free(context);
  }
  modbus_t* context;
};

TEST(ModbusServer, AnswersSentinelsWhileSlipdIsAway) {
  const Serving serving;
  const Plc plc(serving.port());
  std::array<std::uint16_t, kFirstBlock + kBlockSize> read{};
  ASSERT_EQ(modbus_read_input_registers(plc.context, 0, static_cast<int>(read.size()), read.data()),
            static_cast<int>(read.size()));
  EXPECT_EQ(read[0], kMapVersion);
  EXPECT_EQ(read[2], 2);
  EXPECT_EQ(read[3], 1);
  EXPECT_EQ(read[kFirstBlock], SLIPD_STATE_DISCONNECTED);
  EXPECT_EQ(read[kFirstBlock + 2], kUnknown);
}

TEST(ModbusServer, WritesNothingAndReadsNothingElse) {
  const Serving serving;
  const Plc plc(serving.port());
  std::uint16_t word = 0;
  std::uint8_t bit = 0;
  EXPECT_EQ(modbus_write_register(plc.context, 0, 1), -1);
  EXPECT_EQ(errno, EMBXILFUN);
  EXPECT_EQ(modbus_read_registers(plc.context, 0, 1, &word), -1);
  EXPECT_EQ(errno, EMBXILFUN);
  EXPECT_EQ(modbus_read_bits(plc.context, 0, 1, &bit), -1);
  EXPECT_EQ(modbus_read_input_registers(plc.context, kRegisters, 1, &word), -1);
  EXPECT_EQ(errno, EMBXILADD);
  EXPECT_EQ(modbus_read_input_registers(plc.context, kRegisters - 1, 1, &word), 1);
}

TEST(ModbusServer, AClientThatSendsHalfARequestHoldsNobodyUp) {
  const Serving serving;
  const int half = serving.plain();
  ASSERT_EQ(write(half, "\0\1\0\0\0\6\1", 7), 7);
  const Plc plc(serving.port());
  std::uint16_t word = 0;
  EXPECT_EQ(modbus_read_input_registers(plc.context, 0, 1, &word), 1);
  ASSERT_EQ(write(half, "\4\0\0\0\1", 5), 5);
  std::array<char, 64> answer{};
  EXPECT_EQ(read(half, answer.data(), answer.size()), 11);
  close(half);
}

TEST(ModbusServer, ClosesWhatIsNotModbus) {
  const Serving serving;
  for (const std::string& bytes : {std::string("GET / HTTP/1.1\r\n\r\n"), std::string("\0\1\0\0\0\0\0\0", 8),
                                   std::string("\0\1\0\0\xff\xff\1\4", 8), std::string(300, '\0')}) {
    const int fd = serving.plain();
    ASSERT_EQ(write(fd, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    char answer = 0;
    EXPECT_LE(read(fd, &answer, 1), 0);
    close(fd);
  }
}

TEST(ModbusServer, AnswersARequestOfAnotherLengthWithAnException) {
  const Serving serving;
  const int fd = serving.plain();
  ASSERT_EQ(write(fd, "\0\1\0\0\0\4\1\4\0\0", 10), 10);
  std::array<unsigned char, 64> answer{};
  ASSERT_EQ(read(fd, answer.data(), answer.size()), 9);
  EXPECT_EQ(answer[7], 0x84);
  EXPECT_EQ(answer[8], 3);
  close(fd);
}

TEST(ModbusServer, ServesSeveralRequestsOfOnePacket) {
  const Serving serving;
  const int fd = serving.plain();
  const std::string one("\0\1\0\0\0\6\1\4\0\0\0\1", 12);
  const std::string three = one + one + one;
  ASSERT_EQ(write(fd, three.data(), three.size()), static_cast<ssize_t>(three.size()));
  std::array<char, 64> answer{};
  std::size_t got = 0;
  while (got < 33) {
    const auto more = read(fd, answer.data() + got, answer.size() - got);
    ASSERT_GT(more, 0);
    got += static_cast<std::size_t>(more);
  }
  EXPECT_EQ(got, 33U);
  close(fd);
}

TEST(ModbusServer, ClosesConnectionsBeyondItsLimit) {
  const Serving serving(2);
  const Plc one(serving.port()), two(serving.port());
  std::uint16_t word = 0;
  ASSERT_EQ(modbus_read_input_registers(one.context, 0, 1, &word), 1);
  ASSERT_EQ(modbus_read_input_registers(two.context, 0, 1, &word), 1);
  const int fd = serving.plain();
  char byte = 0;
  EXPECT_LE(read(fd, &byte, 1), 0);
  close(fd);
  EXPECT_EQ(modbus_read_input_registers(one.context, 0, 1, &word), 1);
}

}  // namespace
}  // namespace slipd::modbus
