// JSON-RPC 2.0, the part without a socket: a line in, requests or errors out; a result or an error in, a
// line's text out. io thread. Whatever the bytes are, nothing here throws at its caller, and nesting is
// limited before anything is parsed.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slipd::rpc {

inline constexpr int kParseError = -32700;
inline constexpr int kInvalidRequest = -32600;
inline constexpr int kMethodNotFound = -32601;
inline constexpr int kInvalidParams = -32602;
inline constexpr int kInternalError = -32603;
inline constexpr int kTooManyClients = -32000;
inline constexpr int kUnknownSensor = -32001;
inline constexpr int kNotPermitted = -32002;
inline constexpr int kNotPossible = -32003;

inline constexpr std::size_t kLongestLine = std::size_t{64} * 1024;
inline constexpr int kDeepestNesting = 32;
inline constexpr std::size_t kLargestBatch = 64;

// Thrown by methods.
class Error : public std::runtime_error {
 public:
  Error(int code, const std::string& message) : std::runtime_error(message), code_(code) {}
  int code() const noexcept { return code_; }

 private:
  int code_;
};

inline constexpr const char* kNoId = "null";

struct Request {
  std::string method;
  nlohmann::json params;      // an object; empty if there were none
  std::string id = kNoId;     // as JSON
  bool notification = false;  // no id: nobody waits for an answer
  std::optional<std::string>
      refusal;  // the answer, if it is no request: an error, or nothing for a notification
};

struct Line {
  bool batch = false;
  std::vector<Request> requests;
  std::string refusal;  // of the line as a whole: the answer to it, complete
};

// `text`: one line without its end.
Line parse(std::string_view text);

// Answers, complete but for the end of line. Bytes that are no UTF-8 are replaced.
std::string result_text(const std::string& id, std::string_view result);
std::string error_text(const std::string& id, int code, const std::string& message);

// The answers to one line: collected until the last has come, then handed on as one text (one object, or an
// array for a batch), or not at all if there is nothing to say.
class Answers {
 public:
  Answers(bool batch, std::size_t expected, std::function<void(std::string)> done);
  void add(std::string text);  // one answer; empty: a notification's

 private:
  bool batch_;
  std::size_t missing_;
  std::string collected_;
  std::function<void(std::string)> done_;
};

// The right to answer one request, once, now or later.
class Reply {
 public:
  Reply(const Request& request, std::shared_ptr<Answers> answers);
  void result(const nlohmann::ordered_json& value) const;
  void text(std::string_view json) const;  // a result that is written already
  void error(int code, const std::string& message) const;

 private:
  std::string id_;
  bool notification_;
  std::shared_ptr<Answers> answers_;
};

}  // namespace slipd::rpc
