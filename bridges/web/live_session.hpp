// One live page's WebSocket. It has at most one message under way, and keeps only the newest of each kind for
// when that one is sent and the page said that it took the last: so a slow page gets fewer, never old ones.
// Nor does a new page get what was said before it was there: while there is no page, nobody asks slipd for
// more.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "bridges/web/serving.hpp"

namespace slipd::web {

// What a page may send: "ready" (it took the last estimates), "drawn" (the last picture), "look NAME",
// "look".
enum class Word : std::uint8_t { ready, drawn, look, unknown };
struct Said {
  Word word = Word::unknown;
  // Of look: a sensor's name; empty: none.
  std::string name;
};
Said said(std::string_view text);

class LiveSession : public std::enable_shared_from_this<LiveSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  LiveSession(Serving& serving, boost::beast::tcp_stream stream);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  // Answers the handshake and serves.
  void run(Request request);
  void offer_live(const Message& message);
  void offer_status(const Message& message);
  void offer_picture(const std::string& sensor, const Message& message);
  // The sensor of which it could take a picture now; empty: none.
  std::string_view wants() const;
  // Ends it.
  void close();

 private:
  void read();
  void take(std::string_view text);
  // False: it sends more messages than it may.
  bool within_rate();
  void send_next();
  void write(const Message& message, bool text);
  void refuse(std::string_view why);

  Serving& serving_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::beast::flat_static_buffer<1024> input_;
  bool open_ = false, writing_ = false, ready_ = true, drawn_ = true, closing_ = false;
  Message hello_, live_, status_, layout_, picture_, under_way_;
  std::string look_;
  Message layout_sent_;
  double allowance_;
  std::chrono::steady_clock::time_point allowed_at_;
};

}  // namespace slipd::web
