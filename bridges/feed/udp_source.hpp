// Datagrams of one UDP port, for the sensors whose messages come there. All of it runs in the context's
// thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bridges/feed/address.hpp"
#include "bridges/feed/assembler.hpp"
#include "bridges/feed_lane/lane.hpp"

namespace slipd::feed {

class UdpSource {
 public:
  // One sensor.
  struct Listener {
    Lane* lane;
    std::optional<Assembler> assembler;  // none: each datagram is a message
    std::string sender;                  // address whose datagrams count; empty: all
    bool counted;                        // by the sender, in what the lane reads: it knows what is lost
  };

  // Throws boost::system::system_error if the address cannot be listened on.
  UdpSource(boost::asio::io_context& context, const Address& address, std::vector<Listener> listeners);

 private:
  void wait();
  void drain();
  void hand_out(std::size_t bytes);

  boost::asio::ip::udp::socket socket_;
  std::vector<Listener> listeners_;
  std::vector<std::uint8_t> datagram_;
  boost::asio::ip::udp::endpoint from_;
};

}  // namespace slipd::feed
