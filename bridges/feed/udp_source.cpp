#include "bridges/feed/udp_source.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/address.hpp>
#include <utility>

#include "bridges/support/clock.hpp"

namespace slipd::feed {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

constexpr std::size_t kLongestDatagram = 65535;
// What the kernel keeps until it is read: some frames of 20 x 20 taxels with their other fields.
constexpr int kReceiveBuffer = 1 << 20;
// Datagrams that are read at once, before sensors get what they have. A sender that never pauses would
// otherwise keep all back.
constexpr int kMostAtOnce = 256;

}  // namespace

UdpSource::UdpSource(asio::io_context& context, const Address& address, std::vector<Listener> listeners)
    : socket_(context, udp::endpoint(asio::ip::make_address(address.host), address.port)),
      listeners_(std::move(listeners)),
      datagram_(kLongestDatagram) {
  boost::system::error_code ignored;  // the kernel's limit may be lower
  socket_.set_option(asio::socket_base::receive_buffer_size(kReceiveBuffer), ignored);
  socket_.non_blocking(true);
  wait();
}

void UdpSource::wait() {
  socket_.async_wait(udp::socket::wait_read, [this](boost::system::error_code error) {
    if (error) return;
    drain();
    wait();
  });
}

void UdpSource::drain() {
  boost::system::error_code error;
  for (int i = 0; i < kMostAtOnce; ++i) {
    const std::size_t bytes = socket_.receive_from(asio::buffer(datagram_), from_, 0, error);
    if (error) break;
    hand_out(bytes);
  }
  for (const Listener& listener : listeners_) listener.lane->flush();
}

void UdpSource::hand_out(std::size_t bytes) {
  const std::int64_t now_ns = bridges::monotonic_ns();
  const std::string host = from_.address().to_string();
  const Bytes datagram = Bytes(datagram_).first(bytes);
  for (Listener& listener : listeners_) {
    if (!listener.sender.empty() && listener.sender != host) continue;
    if (!listener.assembler) {
      listener.lane->take({{}, datagram}, now_ns);
      continue;
    }
    Message message;
    const std::uint64_t lost = listener.assembler->lost();
    const auto result = listener.assembler->put(host + ':' + std::to_string(from_.port()), datagram, message);
    if (const std::uint64_t more = listener.assembler->lost() - lost; more > 0 && !listener.counted)
      listener.lane->lose(more);
    if (result == Assembler::Result::message) listener.lane->take(message, now_ns);
    if (result == Assembler::Result::corrupt)
      listener.lane->refuse("a datagram had another header, or was there twice");
  }
}

}  // namespace slipd::feed
