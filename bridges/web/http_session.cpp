// One connection of HTTP: reads heads, judges them, and answers from memory, from a recording's file, or with
// what the main thread asks slipd. A request with a body is refused.
#include <unistd.h>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "bridges/web/answers/recordings.hpp"
#include "bridges/web/live_session.hpp"
#include "bridges/web/page_files.hpp"
#include "bridges/web/serving.hpp"

namespace slipd::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

// Scripts, styles and pictures from here only, and nothing within the text of the page.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

Count count_of(Refusal refusal) {
  switch (refusal) {
    case Refusal::host:
      return Count::refused_host;
    case Refusal::origin:
      return Count::refused_origin;
    case Refusal::token:
      return Count::refused_token;
    default:
      return Count::refused_other;
  }
}

}  // namespace

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Serving& serving, asio::ip::tcp::socket socket)
      : serving_(serving), stream_(std::move(socket)), input_(serving.limits.head_bytes) {
    ++serving_.connections;
  }
  ~HttpSession() { --serving_.connections; }
  HttpSession(const HttpSession&) = delete;
  HttpSession& operator=(const HttpSession&) = delete;

  void read() {
    parser_.emplace();
    parser_->header_limit(serving_.limits.head_bytes);
    parser_->body_limit(0);
    // One time for the whole head: bytes that drip in do not prolong it.
    stream_.expires_after(std::chrono::seconds(serving_.limits.head_s));
    http::async_read_header(
        stream_, input_, *parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t) { self->take(error); });
  }

 private:
  using Text = http::response<http::string_body>;

  void take(beast::error_code error) {
    if (error == http::error::end_of_stream || error == asio::error::connection_reset) return close();
    if (error == beast::error::timeout) {
      if (parser_->got_some()) serving_.counts.add(Count::slow);  // else nothing more was asked for
      return close();
    }
    const bool body = error ? error == http::error::body_limit
                            : parser_->chunked() || parser_->content_length().value_or(0) > 0;
    if (error || body) {
      serving_.counts.add(Count::malformed);
      const auto status = body ? http::status::payload_too_large : http::status::bad_request;
      return answer_text(status, "text/plain", "This is no request that slipd-web reads.\n", true);
    }
    answer();
  }

  RequestHead head() const {
    const auto& request = parser_->get();
    const auto field = [&](http::field name) {
      const auto at = request.find(name);
      return at == request.end() ? std::string_view{}
                                 : std::string_view(at->value().data(), at->value().size());
    };
    RequestHead head;
    head.method = {request.method_string().data(), request.method_string().size()};
    head.target = {request.target().data(), request.target().size()};
    head.host = request.count(http::field::host) == 1 ? field(http::field::host) : std::string_view{};
    if (request.count(http::field::origin) > 0) head.origin = field(http::field::origin);
    head.cookie = field(http::field::cookie);
    head.authorization = field(http::field::authorization);
    head.upgrade = beast::websocket::is_upgrade(request);
    return head;
  }

  void answer() {
    const RequestHead asked = head();
    const Route route = route_of(asked.target);
    const Refusal refusal = serving_.rules->judge(asked, route);
    if (refusal != Refusal::none) {
      serving_.counts.add(count_of(refusal));
      return answer_text(static_cast<http::status>(status_of(refusal)), "text/plain; charset=utf-8",
                         std::string(text_of(refusal)) + "\n", true);
    }
    serving_.counts.add(Count::requests);
    switch (route.part) {
      case Part::live:
        return go_live();
      case Part::page:
        return answer_page(route.name);
      case Part::login:
        return answer_login(asked.host);
      case Part::recordings:
        return answer_json(recordings_json(serving_.settings.recordings));
      case Part::recording:
        return answer_recording(route.name);
      case Part::method:
        return answer_method();
      default:
        return answer_json(serving_.counts.json());
    }
  }

  void go_live() {
    if (static_cast<int>(serving_.live.size()) >= serving_.settings.max_browsers) {
      serving_.counts.add(Count::too_many);
      return answer_text(http::status::service_unavailable, "text/plain", "Too many live pages are open.\n",
                         true);
    }
    // cppcheck-suppress accessMoved ; nothing is read from this session afterwards
    std::make_shared<LiveSession>(serving_, std::move(stream_))->run(parser_->release());
  }

  template <typename Response>
  void set_fields(Response& response, const char* type) {
    response.set(http::field::server, "slipd-web");
    response.set(http::field::content_type, type);
    response.set(http::field::cache_control, "no-store");
    response.set("Content-Security-Policy", kPolicy);
    response.set("X-Content-Type-Options", "nosniff");
    response.set("X-Frame-Options", "DENY");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Permissions-Policy", "camera=(), microphone=(), geolocation=()");
  }

  bool head_only() const { return parser_->is_header_done() && parser_->get().method() == http::verb::head; }

  void answer_text(http::status status, const char* type, std::string content, bool end) {
    Text response{status, 11};
    set_fields(response, type);
    response.keep_alive(!end);
    send(std::move(response), std::move(content), end);
  }

  // A HEAD gets the length of what GET would.
  void send(Text response, std::string content, bool end) {
    response.content_length(content.size());
    if (!head_only()) response.body() = std::move(content);
    const auto kept = std::make_shared<Text>(std::move(response));
    stream_.expires_after(std::chrono::seconds(serving_.limits.answer_s));
    http::async_write(stream_, *kept,
                      [self = shared_from_this(), kept, end](beast::error_code error, std::size_t) {
                        self->sent(error, end);
                      });
  }

  void answer_json(std::string json) {
    answer_text(http::status::ok, "application/json", std::move(json), ends());
  }

  void answer_page(const std::string& name) {
    const PageFile* const file = page_file(name);
    if (file != nullptr)
      return answer_text(http::status::ok, std::string(file->type).c_str(), std::string(file->content),
                         ends());
    serving_.counts.add(Count::refused_other);
    answer_text(http::status::not_found, "text/plain; charset=utf-8",
                std::string(text_of(Refusal::unknown)) + "\n", ends());
  }

  void answer_login(std::string_view host) {
    const bool end = ends();
    Text response{http::status::see_other, 11};
    set_fields(response, "text/plain");
    response.set(http::field::location, "./");
    response.set(http::field::set_cookie,
                 serving_.rules->cookie(host) + "; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000");
    response.keep_alive(!end);
    send(std::move(response), {}, end);
  }

  void answer_recording(const std::string& name) {
    const int fd = open_recording(serving_.settings.recordings, name);
    if (fd < 0)
      return answer_text(http::status::not_found, "text/plain; charset=utf-8",
                         "There is no recording by this name.\n", ends());
    beast::file_posix file;
    file.native_handle(fd);
    using File = http::response<http::basic_file_body<beast::file_posix>>;
    const auto kept = std::make_shared<File>();
    beast::error_code error;
    kept->body().reset(std::move(file), error);
    if (error)
      return answer_text(http::status::internal_server_error, "text/plain", "It cannot be read.\n", true);
    kept->result(http::status::ok);
    set_fields(*kept, "application/octet-stream");
    const bool end = ends();
    kept->keep_alive(!end);
    kept->prepare_payload();
    send_file(kept, end);
  }

  // In pieces: each has its own time, so that a large file may take long and a reader that stands still not.
  template <typename File>
  void send_file(const std::shared_ptr<File>& file, bool end) {
    using Fields = http::response_serializer<http::basic_file_body<beast::file_posix>>;
    const auto pieces = std::make_shared<Fields>(*file);
    pieces->limit(std::size_t{64} * 1024);
    send_piece(file, pieces, end);
  }

  template <typename File, typename Pieces>
  void send_piece(const std::shared_ptr<File>& file, const std::shared_ptr<Pieces>& pieces, bool end) {
    stream_.expires_after(std::chrono::seconds(serving_.limits.answer_s));
    const auto next = [self = shared_from_this(), file, pieces, end](beast::error_code error, std::size_t) {
      const bool done = pieces->is_done() || (self->head_only() && pieces->is_header_done());
      if (error || done)
        return self->sent(error == http::error::end_of_stream ? beast::error_code{} : error, end);
      self->send_piece(file, pieces, end);
    };
    if (pieces->is_header_done()) return http::async_write_some(stream_, *pieces, next);
    pieces->split(true);
    http::async_write_header(stream_, *pieces, next);
  }

  void answer_method() {
    constexpr std::size_t kMostWaiting = 64;
    if (serving_.waiting_for_method.size() >= kMostWaiting)
      return answer_text(http::status::service_unavailable, "text/plain", "Too many ask for this.\n", true);
    stream_.expires_after(std::chrono::seconds(serving_.limits.answer_s));
    serving_.waiting_for_method.push_back(
        [self = shared_from_this()](const Message& json) { self->answer_json(*json); });
    serving_.update_wanted();
  }

  bool ends() { return !parser_->keep_alive() || ++served_ >= serving_.limits.requests; }

  void sent(beast::error_code error, bool end) {
    if (error == beast::error::timeout) serving_.counts.add(Count::slow);
    if (error || end) return close();
    read();
  }

  void close() {
    beast::error_code ignored;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  }

  Serving& serving_;
  beast::tcp_stream stream_;
  beast::flat_buffer input_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  int served_ = 0;
};

void serve_http(Serving& serving, asio::ip::tcp::socket socket) {
  std::make_shared<HttpSession>(serving, std::move(socket))->read();
}

}  // namespace slipd::web
