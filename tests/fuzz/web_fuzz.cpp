// Any bytes from browsers: slipd-web's connections on a real socket. The first byte says whether the rest is
// HTTP, or, after a handshake, frames of a WebSocket, and into how many pieces it is cut. Every connection
// ends, and every answer begins as one of HTTP.
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "bridges/web/serving.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using fuzz::demand;
using Tcp = boost::asio::ip::tcp;

constexpr std::string_view kHandshake =
    "GET /live HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: "
    "13\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n";

// One for all inputs: what one leaves behind, a later one would find.
struct World {
  World() : serving(web::Settings{}, [] {}) {
    serving.settings.recordings.clear();
    serving.rules = std::make_unique<web::RequestRules>(std::vector<std::string>{"a"}, "");
    serving.hello = std::make_shared<const std::string>("{}");
    acceptor = Tcp::acceptor(serving.io, Tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0));
  }
  web::Serving serving;
  Tcp::acceptor acceptor{serving.io};
};

void answer_method(web::Serving& serving) {
  const auto json = std::make_shared<const std::string>("{}");
  for (const auto& answer : std::exchange(serving.waiting_for_method, {})) answer(json);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static World world;
  if (size == 0) return 0;
  boost::asio::io_context outside;
  Tcp::socket client(outside);
  client.connect(world.acceptor.local_endpoint());
  serve_http(world.serving, world.acceptor.accept());
  std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  if ((data[0] & 1) != 0) text.insert(0, kHandshake);
  const std::size_t pieces = 1 + (data[0] >> 1) % 4, piece = std::max<std::size_t>(1, text.size() / pieces);
  boost::system::error_code error;
  for (std::size_t at = 0; at < text.size() && !error; at += piece) {
    boost::asio::write(client, boost::asio::buffer(text.data() + at, std::min(piece, text.size() - at)),
                       error);
    world.serving.io.restart();
    world.serving.io.poll();
    answer_method(world.serving);
  }
  client.shutdown(Tcp::socket::shutdown_send, error);
  std::string heard;
  char buffer[65536];
  client.non_blocking(true);
  for (int quiet = 0; world.serving.connections > 0 && quiet < 1000; ++quiet) {
    world.serving.io.restart();
    world.serving.io.poll();
    answer_method(world.serving);
    const std::size_t got = client.read_some(boost::asio::buffer(buffer), error);
    heard.append(buffer, got);
    if (error && error != boost::asio::error::would_block) client.close(error);
  }
  demand(world.serving.connections == 0 && world.serving.live.empty() &&
         world.serving.waiting_for_method.empty());
  demand(heard.empty() || heard.starts_with("HTTP/1.1 "));
  demand(heard.find("Access-Control-Allow") == heard.npos);
  return 0;
}
