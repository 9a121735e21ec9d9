#include "tests/system/faults/cutting_proxy.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <stdexcept>

namespace slipd::testing {
namespace {

constexpr int kAnswersBefore = 5;  // answers that pass before a connection is cut
constexpr int kLookMs = 20;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

UniqueFd tcp() {
  return UniqueFd(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
}

bool readable(const UniqueFd& fd) {
  pollfd wait{fd.get(), POLLIN, 0};
  return poll(&wait, 1, kLookMs) == 1;
}

}  // namespace

CuttingProxy::CuttingProxy(std::uint16_t device_port) : device_port_(device_port), listener_(tcp()) {
  sockaddr_in address = loopback(0);
  socklen_t length = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener_.get(), any, length) != 0 || listen(listener_.get(), 1) != 0 ||
      getsockname(listener_.get(), any, &length) != 0) {
    throw std::runtime_error("a port for the proxy");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void CuttingProxy::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!readable(listener_)) continue;
    const UniqueFd slipd(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (slipd) pass_on(stop, slipd);
  }
}

void CuttingProxy::pass_on(const std::stop_token& stop, const UniqueFd& slipd) {
  const UniqueFd device = tcp();
  const sockaddr_in address = loopback(device_port_);
  if (connect(device.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return;
  std::array<char, 1024> bytes{};
  for (int answers = 0; !stop.stop_requested();) {
    std::array<pollfd, 2> waits{{{slipd.get(), POLLIN, 0}, {device.get(), POLLIN, 0}}};
    if (poll(waits.data(), waits.size(), kLookMs) <= 0) continue;
    if (waits[0].revents != 0) {
      const auto got = recv(slipd.get(), bytes.data(), bytes.size(), 0);
      if (got <= 0 || send(device.get(), bytes.data(), static_cast<std::size_t>(got), MSG_NOSIGNAL) != got)
        return;
    }
    if (waits[1].revents == 0) continue;
    const auto got = recv(device.get(), bytes.data(), bytes.size(), 0);
    if (got <= 0) return;
    const bool cut = cutting_ && ++answers > kAnswersBefore;
    // One byte later each time, so that every position is cut.
    const auto length =
        cut ? static_cast<std::size_t>(cuts_ % static_cast<int>(got)) : static_cast<std::size_t>(got);
    send(slipd.get(), bytes.data(), length, MSG_NOSIGNAL);
    if (!cut) continue;
    // Every second time with a reset instead of an end.
    const linger at_once{1, 0};
    if (cuts_ % 2 == 0) setsockopt(slipd.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ++cuts_;
    return;
  }
}

}  // namespace slipd::testing
