#include "daemon/rpc/protocol/plain_request.hpp"

namespace slipd::rpc {
namespace {

constexpr bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

// Reads while the text is simple. After anything else lost() is true, and nothing more is read.
class Reader {
 public:
  explicit Reader(std::string_view text) noexcept : rest_(text) {}

  bool lost() const noexcept { return lost_; }
  void lose() noexcept { lost_ = true; }
  bool at_end() noexcept { return !lost_ && peek() == '\0' && rest_.empty(); }

  // The next byte that is not white space; 0: the end.
  char peek() noexcept {
    while (!rest_.empty() && (rest_.front() == ' ' || rest_.front() == '\t' || rest_.front() == '\r'))
      rest_.remove_prefix(1);
    return rest_.empty() ? '\0' : rest_.front();
  }

  void expect(char c) noexcept {
    if (peek() != c || rest_.empty()) return lose();
    rest_.remove_prefix(1);
  }

  // A string, with its quotes.
  std::string_view quoted() noexcept {
    if (peek() != '"') return lose(), std::string_view{};
    std::size_t end = 1;
    while (end < rest_.size() && rest_[end] >= ' ' && rest_[end] <= '~' && rest_[end] != '"' &&
           rest_[end] != '\\')
      ++end;
    if (end == rest_.size() || rest_[end] != '"') return lose(), std::string_view{};
    return cut(end + 1);
  }

  std::string_view string() noexcept {
    const std::string_view text = quoted();
    return lost_ ? text : text.substr(1, text.size() - 2);
  }

  // An integer without sign or leading zeros.
  std::string_view count() noexcept {
    constexpr std::size_t kMostDigits = 18;
    std::size_t end = 0;
    while (end < rest_.size() && is_digit(rest_[end])) ++end;
    const bool plain = end > 0 && end <= kMostDigits && (rest_[0] != '0' || end == 1);
    const bool goes_on = end < rest_.size() && (rest_[end] == '.' || (rest_[end] | 0x20) == 'e');
    if (!plain || goes_on) return lose(), std::string_view{};
    return cut(end);
  }

  // An object. `member` is called with each key and reads its value.
  template <typename Member>
  void object(Member member) {
    expect('{');
    if (!lost_ && peek() == '}') return expect('}');
    while (!lost_) {
      const std::string_view key = string();
      expect(':');
      if (!lost_) member(key);
      if (lost_ || peek() != ',') return expect('}');
      expect(',');
    }
  }

 private:
  std::string_view cut(std::size_t bytes) noexcept {
    const std::string_view head = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return head;
  }
  std::string_view rest_;
  bool lost_ = false;
};

}  // namespace

std::optional<Request> plain_request(std::string_view text) {
  Reader reader(text);
  std::string_view version, id, method;
  std::optional<Request> request(std::in_place);
  request->params = nlohmann::json::object();
  bool params_seen = false;
  reader.object([&](std::string_view key) {
    if (key == "jsonrpc" && version.empty()) {
      version = reader.string();
    } else if (key == "id" && id.empty()) {
      id = reader.peek() == '"' ? reader.quoted() : reader.count();
    } else if (key == "method" && method.empty()) {
      method = reader.string();
    } else if (key == "params" && !params_seen) {
      params_seen = true;
      reader.object([&](std::string_view name) {
        if (request->params.contains(name)) return reader.lose();
        request->params[std::string(name)] = reader.string();
      });
    } else {
      reader.lose();
    }
  });
  if (!reader.at_end() || version != "2.0" || id.empty() || method.empty()) return std::nullopt;
  request->id = id;
  request->method = method;
  return request;
}

}  // namespace slipd::rpc
