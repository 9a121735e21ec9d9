#include "bridges/feed/websocket_source.hpp"

#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>

#include "bridges/support/clock.hpp"

namespace slipd::feed {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;

constexpr std::chrono::seconds kConnectPatience{5};
// A server that has said nothing for so long is asked, and is gone if it does not answer in as long again.
constexpr std::chrono::seconds kIdle{5};
constexpr std::chrono::milliseconds kPause{500};               // before the next attempt
constexpr std::size_t kLongestMessage = std::size_t{4} << 20;  // bytes: 17 704 taxels as text

}  // namespace

WebSocketSource::WebSocketSource(asio::io_context& context, Address address, Lane& lane)
    : context_(context), address_(std::move(address)), lane_(lane), resolver_(context), pause_(context) {
  resolve();
}

void WebSocketSource::fail(const char* what, const Error& error) {
  lane_.source_is(std::string(what) + " ws://" + address_.host + ":" + std::to_string(address_.port) +
                  address_.path + ": " + error.message());
  // The stream's own handlers may still run in this call: it goes in the next one.
  pause_.expires_after(kPause);
  pause_.async_wait([this](Error) {
    stream_.reset();
    input_.clear();
    resolve();
  });
}

void WebSocketSource::resolve() {
  resolver_.async_resolve(address_.host, std::to_string(address_.port),
                          [this](const Error& error, const tcp::resolver::results_type& found) {
                            if (error) return fail("cannot find", error);
                            connect(found);
                          });
}

void WebSocketSource::connect(const tcp::resolver::results_type& found) {
  stream_.emplace(context_);
  beast::tcp_stream& socket = beast::get_lowest_layer(*stream_);
  socket.expires_after(kConnectPatience);
  socket.async_connect(found, [this](const Error& error, const tcp::endpoint&) {
    if (error) return fail("cannot connect to", error);
    shake_hands();
  });
}

void WebSocketSource::shake_hands() {
  beast::get_lowest_layer(*stream_).expires_never();  // the WebSocket has time limits of its own
  stream_->set_option(websocket::stream_base::timeout{kConnectPatience, kIdle, true});
  stream_->read_message_max(kLongestMessage);
  stream_->async_handshake(address_.host + ":" + std::to_string(address_.port), address_.path,
                           [this](const Error& error) {
                             if (error) return fail("no WebSocket at", error);
                             lane_.source_is("");
                             read();
                           });
}

void WebSocketSource::read() {
  stream_->async_read(input_, [this](const Error& error, std::size_t) {
    if (error) return fail("lost", error);
    take();
    read();
    // Behind a message that is there already.
    asio::post(context_, [this] { lane_.flush(); });
  });
}

void WebSocketSource::take() {
  const auto data = input_.cdata();
  lane_.take({{}, {static_cast<const std::uint8_t*>(data.data()), data.size()}}, bridges::monotonic_ns());
  input_.consume(input_.size());
}

}  // namespace slipd::feed
