// Messages of a WebSocket server, for one sensor. It connects again by itself. All of it runs in the
// context's thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <optional>
#include <string>

#include "bridges/feed/address.hpp"
#include "bridges/feed_lane/lane.hpp"

namespace slipd::feed {

class WebSocketSource {
 public:
  // `lane` must live longer.
  WebSocketSource(boost::asio::io_context& context, Address address, Lane& lane);

 private:
  using Stream = boost::beast::websocket::stream<boost::beast::tcp_stream>;
  using Error = boost::system::error_code;

  void resolve();
  void connect(const boost::asio::ip::tcp::resolver::results_type& found);
  void shake_hands();
  void read();
  void take();
  void fail(const char* what, const Error& error);

  boost::asio::io_context& context_;
  const Address address_;
  Lane& lane_;
  boost::asio::ip::tcp::resolver resolver_;
  boost::asio::steady_timer pause_;
  std::optional<Stream> stream_;  // none: between two connections
  boost::beast::flat_buffer input_;
};

}  // namespace slipd::feed
