// A receiver that hangs makes nobody wait.
#include "daemon/log/datagram.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <chrono>
#include <cstddef>
#include <string>

#include "core/storage/unique_fd.hpp"

namespace slipd {
namespace {

TEST(Datagram, IsLostWhereItsReceiverTakesNone) {
  using Steady = std::chrono::steady_clock;
  const std::string address = "@slipd-datagram-test-" + std::to_string(::getpid());
  const UniqueFd receiver(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un at{.sun_family = AF_UNIX, .sun_path = {}};
  address.copy(static_cast<char*>(at.sun_path), address.size());
  at.sun_path[0] = '\0';
  ASSERT_EQ(::bind(receiver.get(), reinterpret_cast<const sockaddr*>(&at),
                   static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size())),
            0);
  int taken = 0;
  while (send_datagram(address, "a line", WhenFull::lose)) ++taken;
  EXPECT_GT(taken, 0);
  const auto begun = Steady::now();
  EXPECT_FALSE(send_datagram(address, "READY=1", WhenFull::wait));
  EXPECT_LT(Steady::now() - begun, std::chrono::seconds(30)) << "0.1 s, on a machine that is not busy";
  char line[16];
  ASSERT_GT(::recv(receiver.get(), line, sizeof line, 0), 0);
  EXPECT_TRUE(send_datagram(address, "READY=1", WhenFull::wait));
}

}  // namespace
}  // namespace slipd
