// The USB/IP server with a client that follows the kernel's protocol, so that it is tested where no kernel
// can attach it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "tests/devices/contacts.hpp"

namespace slipd::devices {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

constexpr std::uint32_t kOut = 0, kIn = 1;

class UsbipDevice : public ::testing::Test {
 protected:
  void SetUp() override { attach(); }

  void attach() {
    host_ = Fd(checked(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), "socket"));
    const int yes = 1;  // without a delay for small messages: loopback then delivers them at once
    ::setsockopt(host_.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(simulator_.port().place())));
    checked(::connect(host_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), "connect");
    Bytes import{0x01, 0x11, 0x80, 0x03, 0, 0, 0, 0, '1', '-', '1'};
    import.resize(40, 0);
    const Bytes answer = exchange(import, 8 + 312);
    ASSERT_EQ(Bytes(answer.begin(), answer.begin() + 8), (Bytes{0x01, 0x11, 0x00, 0x03, 0, 0, 0, 0}));
    EXPECT_EQ(std::string(answer.begin() + 8 + 256, answer.begin() + 8 + 259), "1-1");
  }

  void say(const Bytes& bytes) {
    checked(static_cast<int>(::send(host_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL)), "send");
    simulator_.port().serve();  // takes the connection
    simulator_.port().serve();  // reads from it
  }

  Bytes receive(std::size_t size) {
    Bytes got(size);
    const ssize_t length = ::recv(host_.get(), got.data(), size, MSG_DONTWAIT);
    got.resize(static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
    return got;
  }

  Bytes exchange(const Bytes& bytes, std::size_t size) {
    say(bytes);
    return receive(size);
  }

  static Bytes submit(std::uint32_t sequence, std::uint32_t direction, std::uint32_t endpoint,
                      std::uint32_t length, const Bytes& setup = Bytes(8, 0)) {
    Bytes out;
    for (const std::uint32_t word : {1U, sequence, 0x10001U, direction, endpoint, 0U, length, 0U, 0U, 0U})
      put_be(out, word);
    append(out, setup);
    return out;
  }

  static std::int32_t word(const Bytes& bytes, std::size_t index) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | bytes.at(4 * index + i);
    return static_cast<std::int32_t>(value);
  }

  void start() { exchange(submit(1, kIn, 0, 1, {0xC0, 0xC7, 100, 0, 0xFF, 0, 1, 0}), 49); }

  DeviceSimulator simulator_{takktile(), pattern(takktile()), make_usbip_port(takktile(), 0, "S1")};
  Fd host_;
};

TEST_F(UsbipDevice, DescribesItselfOnEndpointZero) {
  const Bytes answer = exchange(submit(7, kIn, 0, 18, {0x80, 6, 0, 1, 0, 0, 18, 0}), 48 + 18);
  ASSERT_THAT(answer, SizeIs(48 + 18));
  EXPECT_EQ(word(answer, 0), 3);   // reply to a submit
  EXPECT_EQ(word(answer, 1), 7);   // sequence number of the request
  EXPECT_EQ(word(answer, 5), 0);   // status: success
  EXPECT_EQ(word(answer, 6), 18);  // bytes transferred
  EXPECT_EQ(answer[48 + 8], 0xe3);
}

TEST_F(UsbipDevice, StallsOnAnUnknownRequest) {
  const Bytes answer = exchange(submit(8, kIn, 0, 1, {0xC0, 0x11, 0, 0, 0, 0, 1, 0}), 48);
  ASSERT_THAT(answer, SizeIs(48));
  EXPECT_EQ(word(answer, 5), -EPIPE);
}

TEST_F(UsbipDevice, AnswersABulkTransferWhenThereIsAScan) {
  start();
  EXPECT_THAT(exchange(submit(2, kIn, 1, 512), 48 + 512), SizeIs(0)) << "nothing yet";
  simulator_.step();
  const Bytes answer = receive(48 + 512);
  ASSERT_THAT(answer, SizeIs(48 + 160));
  EXPECT_EQ(word(answer, 1), 2);
  EXPECT_EQ(word(answer, 6), 160);
}

TEST_F(UsbipDevice, FillsSmallTransfersOneAfterTheOther) {
  start();
  simulator_.step();
  Bytes all;
  for (std::uint32_t sequence = 2; sequence < 5; ++sequence) {
    const Bytes answer = exchange(submit(sequence, kIn, 1, 64), 48 + 64);
    all.insert(all.end(), answer.begin() + 48, answer.end());
  }
  EXPECT_THAT(all, SizeIs(160)) << "64 + 64 + 32";
}

TEST_F(UsbipDevice, GivesBackATransferThatTheHostTakesBack) {
  start();
  say(submit(2, kIn, 1, 512));
  Bytes unlink;
  for (const std::uint32_t value : {2U, 3U, 0x10001U, kOut, 0U, 2U}) put_be(unlink, value);
  unlink.resize(48, 0);
  const Bytes answer = exchange(unlink, 48);
  EXPECT_EQ(word(answer, 0), 4);
  EXPECT_EQ(word(answer, 1), 3);
  EXPECT_EQ(word(answer, 5), -ECONNRESET);
  simulator_.step();
  EXPECT_THAT(receive(48 + 512), SizeIs(0)) << "nobody waits for it any more";
}

TEST_F(UsbipDevice, TakesARequestThatComesInPieces) {
  const Bytes whole = submit(7, kIn, 0, 18, {0x80, 6, 0, 1, 0, 0, 18, 0});
  say(Bytes(whole.begin(), whole.begin() + 20));
  EXPECT_THAT(receive(100), SizeIs(0));
  EXPECT_THAT(exchange(Bytes(whole.begin() + 20, whole.end()), 100), SizeIs(48 + 18));
}

TEST_F(UsbipDevice, HangsUpWhenUnpluggedAndCanBeAttachedAgain) {
  simulator_.order("unplug");
  simulator_.step();
  char byte = 0;
  EXPECT_EQ(::recv(host_.get(), &byte, 1, 0), 0) << "the connection is closed";
  simulator_.order("plug");
  simulator_.step();
  attach();
}

}  // namespace
}  // namespace slipd::devices
