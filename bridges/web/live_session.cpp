#include "bridges/web/live_session.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <utility>

namespace slipd::web {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

namespace {

constexpr std::size_t kLongestName = 63;  // of a sensor, bytes

}  // namespace

Said said(std::string_view text) {
  constexpr std::string_view kLook = "look";
  if (text == "ready") return {Word::ready, {}};
  if (text == "drawn") return {Word::drawn, {}};
  if (text == kLook) return {Word::look, {}};
  if (!text.starts_with(kLook) || text[kLook.size()] != ' ') return {};
  const std::string_view name = text.substr(kLook.size() + 1);
  if (name.empty() || name.size() > kLongestName) return {};
  return {Word::look, std::string(name)};
}

LiveSession::LiveSession(Serving& serving, beast::tcp_stream stream)
    : serving_(serving),
      stream_(std::move(stream)),
      allowance_(serving.limits.messages_at_once),
      allowed_at_(std::chrono::steady_clock::now()) {
  serving_.live.insert(this);
  ++serving_.connections;
}

LiveSession::~LiveSession() {
  serving_.live.erase(this);
  --serving_.connections;
  serving_.update_wanted();
}

void LiveSession::run(Request request) {
  beast::get_lowest_layer(stream_).expires_never();  // the WebSocket has time limits of its own
  auto limits = websocket::stream_base::timeout::suggested(beast::role_type::server);
  limits.handshake_timeout = std::chrono::seconds(serving_.limits.head_s);
  limits.idle_timeout = std::chrono::seconds(serving_.limits.ready_s);
  stream_.set_option(limits);
  stream_.read_message_max(serving_.limits.message_bytes);
  beast::error_code ignored;
  beast::get_lowest_layer(stream_).socket().set_option(
      asio::socket_base::send_buffer_size(serving_.limits.send_buffer_bytes), ignored);
  beast::get_lowest_layer(stream_).socket().set_option(asio::ip::tcp::no_delay(true), ignored);
  const auto kept = std::make_shared<Request>(std::move(request));
  stream_.async_accept(*kept, [self = shared_from_this(), kept](beast::error_code error) {
    if (error) return;
    self->open_ = true;
    self->serving_.counts.add(Count::live_pages);
    self->hello_ = self->serving_.hello;
    self->serving_.update_wanted();
    self->read();
    self->send_next();
  });
}

void LiveSession::read() {
  stream_.async_read(input_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error == websocket::error::message_too_big || error == websocket::error::bad_opcode ||
        error == websocket::error::bad_frame_payload || error == websocket::error::bad_reserved_bits ||
        error == websocket::error::bad_unmasked_frame)
      self->serving_.counts.add(Count::bad_messages);
    if (error || self->closing_) return;
    const auto data = self->input_.data();
    const std::string text(static_cast<const char*>(data.data()), data.size());
    self->input_.consume(data.size());
    self->take(text);
    if (!self->closing_) self->read();
  });
}

void LiveSession::take(std::string_view text) {
  Said message = said(text);
  if (!stream_.got_text() || message.word == Word::unknown) return refuse("no message of this page");
  if (!within_rate()) return refuse("too many messages");
  switch (message.word) {
    case Word::ready:
      ready_ = true;
      break;
    case Word::drawn:
      drawn_ = true;
      break;
    default:
      look_ = std::move(message.name);
      picture_ = nullptr;
      layout_sent_ = nullptr;
      drawn_ = true;
      break;
  }
  serving_.update_wanted();
  send_next();
}

bool LiveSession::within_rate() {
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> passed = now - std::exchange(allowed_at_, now);
  const Limits& limits = serving_.limits;
  allowance_ = std::min(limits.messages_at_once, allowance_ + limits.messages_hz * passed.count()) - 1;
  return allowance_ >= 0;
}

void LiveSession::offer_live(const Message& message) {
  if (live_) serving_.counts.add(Count::passed_over);
  live_ = message;
  send_next();
}

void LiveSession::offer_status(const Message& message) {
  status_ = message;
  send_next();
}

void LiveSession::offer_picture(const std::string& sensor, const Message& message) {
  if (sensor != look_) return;
  if (picture_) serving_.counts.add(Count::passed_over);
  picture_ = message;
  send_next();
}

std::string_view LiveSession::wants() const {
  return open_ && !closing_ && drawn_ && !picture_ ? std::string_view(look_) : std::string_view{};
}

// The sentence goes first that says most.
void LiveSession::send_next() {
  if (!open_ || writing_ || closing_) return;
  if (hello_) return write(std::exchange(hello_, nullptr), true);
  if (live_ && ready_) {
    ready_ = false;
    return write(std::exchange(live_, nullptr), true);
  }
  if (status_) return write(std::exchange(status_, nullptr), true);
  if (!picture_ || !drawn_) return;
  const auto layout = serving_.layouts.find(look_);
  if (layout != serving_.layouts.end() && layout->second != layout_sent_) {
    layout_sent_ = layout->second;
    return write(layout_sent_, false);
  }
  drawn_ = false;
  write(std::exchange(picture_, nullptr), false);
}

void LiveSession::write(const Message& message, bool text) {
  writing_ = true;
  under_way_ = message;
  stream_.text(text);
  stream_.async_write(asio::buffer(*under_way_),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->writing_ = false;
                        self->under_way_ = nullptr;
                        if (error) return;
                        self->serving_.counts.add(Count::messages);
                        self->serving_.update_wanted();
                        self->send_next();
                      });
}

void LiveSession::refuse(std::string_view why) {
  serving_.counts.add(Count::bad_messages);
  closing_ = true;
  stream_.async_close({websocket::close_code::policy_error, std::string(why)},
                      [self = shared_from_this()](beast::error_code) { self->close(); });
}

void LiveSession::close() {
  closing_ = true;
  beast::get_lowest_layer(stream_).close();
}

}  // namespace slipd::web
