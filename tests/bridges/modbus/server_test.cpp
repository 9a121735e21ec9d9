// The server without slipd or with one that hangs, with libmodbus as its client and with bytes that are no
// Modbus.
#include "bridges/modbus/server.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <modbus.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/free_port.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::modbus {
namespace {

// The server in a thread of its own.
class Serving {
 public:
  explicit Serving(std::size_t max_clients = 16, const std::string& slipd = "/nowhere/slipd.sock")
      : port_(testing::free_port()) {
    ServerSettings settings;
    settings.port = port_;
    settings.max_clients = max_clients;
    settings.blocks = {"left"};
    settings.socket = slipd;
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

// A slipd that answers requests until one of the method `hangs_at`, and that one never.
class HangingSlipd {
 public:
  explicit HangingSlipd(std::string hangs_at)
      : hangs_at_(std::move(hangs_at)), listening_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    path().copy(at.sun_path, sizeof at.sun_path - 1);
    EXPECT_EQ(bind(listening_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(listen(listening_, SOMAXCONN), 0);
  }
  ~HangingSlipd() {
    forget();
    close(listening_);
  }
  std::string path() const { return folder_.file("s.sock").string(); }

  // Until somebody waits for the answer that will not come. False: nobody came.
  bool await_request() {
    forget();
    for (;;) {
      std::vector<pollfd> ready{{listening_, POLLIN, 0}};
      for (const int fd : clients_) ready.push_back({fd, POLLIN, 0});
      if (poll(ready.data(), ready.size(), testing::kPollPatience) <= 0) return false;
      if (ready[0].revents != 0) clients_.push_back(accept(listening_, nullptr, nullptr));
      for (std::size_t i = 1; i < ready.size(); ++i) {
        if (ready[i].revents != 0 && take_request(ready[i].fd)) return true;
      }
    }
  }
  // Whether it is still waited for: the connection was not closed since.
  bool is_waited_for() const {
    char byte = 0;
    return recv(asking_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) < 0 && errno == EAGAIN;
  }

 private:
  bool take_request(int fd) {
    std::array<char, 4096> text{};
    const auto got = read(fd, text.data(), text.size());
    if (got <= 0) {
      std::erase(clients_, fd);
      close(fd);
      return false;
    }
    const auto request = nlohmann::json::parse(std::string_view(text.data(), static_cast<std::size_t>(got)));
    asking_ = fd;
    if (request.at("method") == hangs_at_) return true;
    const std::string answer =
        nlohmann::json{{"jsonrpc", "2.0"}, {"id", request.at("id")}, {"result", nlohmann::json::object()}}
            .dump() +
        "\n";
    EXPECT_EQ(write(fd, answer.data(), answer.size()), static_cast<ssize_t>(answer.size()));
    return false;
  }
  void forget() {
    for (const int fd : clients_) close(fd);
    clients_.clear();
  }

  std::string hangs_at_;
  testing::TempFolder folder_;
  int listening_;
  int asking_ = -1;
  std::vector<int> clients_;
};

TEST(ModbusServer, AnswersWhileItWaitsForSlipd) {
  for (const char* const method : {"version", "gamma", "attach"}) {
    HangingSlipd slipd(method);
    const Serving serving(16, slipd.path());
    const Plc plc(serving.port());
    bool answered_meanwhile = false;
    // On a machine that does much else an answer may come after the end of the wait. A server that waits
    // itself answers after it each time.
    for (int attempt = 0; attempt < 20 && !answered_meanwhile; ++attempt) {
      ASSERT_TRUE(slipd.await_request()) << method;
      std::uint16_t alive = 0;
      ASSERT_EQ(modbus_read_input_registers(plc.context, 2, 1, &alive), 1);
      EXPECT_EQ(alive, 2);
      answered_meanwhile = slipd.is_waited_for();
    }
    EXPECT_TRUE(answered_meanwhile) << method;
  }
}

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
